#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// A camera of a COLMAP model without distortion (PINHOLE, SIMPLE_PINHOLE).
struct ColmapCamera {
  std::uint32_t id = 0;
  std::size_t width = 0, height = 0;  ///< Of the images [pixels].
  PinholeIntrinsics intrinsics;       ///< As stored: pixel centres are at 0.5, 1.5, ...
};

struct ColmapImage {
  std::uint32_t id = 0, camera_id = 0;
  std::string name;  ///< Path below the folder of the images.
  /// Frame x right, y down, z forward. The inverse of what the file holds.
  RigidMotion world_from_view = RigidMotion::Identity();
};

/// That an image saw a point.
struct ColmapSighting {
  std::uint32_t image_id = 0;
  std::uint32_t point = 0;  ///< Index into `points`.
};

/// A sparse model. Its unit is arbitrary.
struct ColmapModel {
  std::vector<ColmapCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<Eigen::Vector3d> points;  ///< World frame.
  std::vector<ColmapSighting> sightings;
};

/// The points of a model alone.
struct ColmapPoints {
  std::vector<Eigen::Vector3d> points;
  std::vector<ColmapSighting> sightings;
};

/// Reads `cameras`, `images` and `points3D` of a folder, each `.bin` or, where there is none,
/// `.txt`. The points may be missing. kBadInput names file and place; for a camera with distortion
/// the remedy is COLMAP's image_undistorter.
Result<ColmapModel> read_colmap_model(const std::filesystem::path& folder);

/// Whether a folder holds cameras and images of a model.
bool has_colmap_model(const std::filesystem::path& folder);

/// The parsers behind it, on the content of `path`: binary files ...
Result<std::vector<ColmapCamera>> parse_colmap_cameras_bin(std::string_view content,
                                                           const std::filesystem::path& path);
Result<std::vector<ColmapImage>> parse_colmap_images_bin(std::string_view content,
                                                         const std::filesystem::path& path);
Result<ColmapPoints> parse_colmap_points_bin(std::string_view content,
                                             const std::filesystem::path& path);
/// ... and text files.
Result<std::vector<ColmapCamera>> parse_colmap_cameras_txt(std::string_view content,
                                                           const std::filesystem::path& path);
Result<std::vector<ColmapImage>> parse_colmap_images_txt(std::string_view content,
                                                         const std::filesystem::path& path);
Result<ColmapPoints> parse_colmap_points_txt(std::string_view content,
                                             const std::filesystem::path& path);

/// What the two forms share. `place` begins their errors.
Result<ColmapCamera> colmap_camera(std::uint32_t id, const std::string& model, double width,
                                   double height, const std::vector<double>& parameters,
                                   const std::filesystem::path& path, const std::string& place);
/// `pose` is qw qx qy qz tx ty tz, view from world.
Result<ColmapImage> colmap_image(std::uint32_t id, std::uint32_t camera_id, const double* pose,
                                 std::string_view name, const std::filesystem::path& path,
                                 const std::string& place);

}  // namespace relief
