#pragma once

#include <array>
#include <filesystem>
#include <string_view>

#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/pose_beside.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"
#include "scan/io/workspaces/rgbd/nerf_transforms.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"

namespace relief::testing {

/// A parser of other programs' projects that works in memory.
struct WorkspaceParser {
  std::string_view name;
  void (*parse)(std::string_view content);
};

template <auto kParser>
void parse_with(std::string_view content) {
  static const std::filesystem::path path = "fuzz";
  (void)kParser(content, path);
}

inline void parse_mlp(std::string_view content) {
  (void)parse_meshlab_mlp(std::string(content), "fuzz");
}

inline void parse_transforms(std::string_view content) {
  (void)parse_nerf_transforms(content, "fuzz");
}

inline void parse_json_camera(std::string_view content) { (void)parse_camera_json(content); }

/// The first byte of an input, as an index, selects the parser.
inline constexpr std::array<WorkspaceParser, 24> kWorkspaceParsers = {
    {{"colmap_array", parse_with<decode_colmap_array>},
     {"colmap_cameras_bin", parse_with<parse_colmap_cameras_bin>},
     {"colmap_images_bin", parse_with<parse_colmap_images_bin>},
     {"colmap_points_bin", parse_with<parse_colmap_points_bin>},
     {"colmap_cameras_txt", parse_with<parse_colmap_cameras_txt>},
     {"colmap_images_txt", parse_with<parse_colmap_images_txt>},
     {"colmap_points_txt", parse_with<parse_colmap_points_txt>},
     {"tum_list", parse_with<parse_tum_list>},
     {"tum_associations", parse_with<parse_tum_associations>},
     {"tum_trajectory", parse_with<parse_tum_trajectory>},
     {"log_trajectory", parse_with<parse_log_trajectory>},
     {"open3d_trajectory", parse_with<parse_open3d_trajectory>},
     {"open3d_camera", parse_with<parse_open3d_camera>},
     {"calibration", parse_with<parse_calibration_text>},
     {"camera_json", parse_json_camera},
     {"camera_npy", parse_with<parse_camera_npy>},
     {"camera_yaml", parse_with<parse_camera_yaml>},
     {"json_poses", parse_with<parse_json_poses>},
     {"npy_poses", parse_with<parse_npy_poses>},
     {"pose_table", parse_with<parse_pose_table>},
     {"matrix", parse_with<parse_matrix_text>},
     {"middlebury", parse_with<parse_middlebury_par>},
     {"mlp", parse_mlp},
     {"nerf_transforms", parse_transforms}}};

}  // namespace relief::testing
