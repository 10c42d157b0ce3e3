#include "scan/io/workspaces/colmap/colmap_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

template <typename T>
using ColmapParser = Result<T> (*)(std::string_view, const fs::path&);

// Reads `stem`.bin with one parser, or else `stem`.txt with the other.
template <typename T>
Result<T> read_colmap_part(const fs::path& stem, ColmapParser<T> binary, ColmapParser<T> text) {
  const fs::path bin = stem.string() + ".bin", txt = stem.string() + ".txt";
  const bool is_text = !is_file(bin) && is_file(txt);
  const fs::path& path = is_text ? txt : bin;
  const auto content = read_file(path);
  if (!content) return content.error();
  return (is_text ? text : binary)(*content, path);
}

bool has_colmap_part(const fs::path& stem) {
  return is_file(stem.string() + ".bin") || is_file(stem.string() + ".txt");
}

template <typename T>
Result<void> check_unique_ids(std::vector<T> items, const char* what, const fs::path& folder) {
  std::sort(items.begin(), items.end(), [](const T& a, const T& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < items.size(); ++i)
    if (items[i].id == items[i - 1].id)
      return bad_input(folder, std::string("two ") + what + " of the model have the number " +
                                   std::to_string(items[i].id) + "; write the model again");
  return {};
}

}  // namespace

Result<ColmapCamera> colmap_camera(std::uint32_t id, const std::string& model, double width,
                                   double height, const std::vector<double>& parameters,
                                   const fs::path& path, const std::string& place) {
  const bool simple = model == "SIMPLE_PINHOLE";
  if (!simple && model != "PINHOLE")
    return bad_input(path, place + "camera " + std::to_string(id) + " has the model " + model +
                               "; depth maps belong to images without distortion (PINHOLE): run "
                               "colmap image_undistorter, and read the workspace it writes");
  if (!(width >= 1.0 && width <= kMaxImageSide && height >= 1.0 && height <= kMaxImageSide))
    return bad_input(path, place + "camera " + std::to_string(id) +
                               " has no usable image size (1 to " + std::to_string(kMaxImageSide) +
                               " pixels a side)");
  if (parameters.size() != (simple ? 3u : 4u))
    return bad_input(path, place + "expected " + (simple ? "f cx cy" : "fx fy cx cy") +
                               " after the size of camera " + std::to_string(id));
  const std::size_t c = simple ? 1 : 2;
  ColmapCamera camera{id,
                      static_cast<std::size_t>(width),
                      static_cast<std::size_t>(height),
                      {parameters[0], parameters[c - 1], parameters[c], parameters[c + 1]}};
  const PinholeIntrinsics& k = camera.intrinsics;
  if (!std::isfinite(k.fx * k.fy * k.cx * k.cy) || k.fx == 0.0 || k.fy == 0.0)
    return bad_input(path, place + "camera " + std::to_string(id) +
                               " needs focal lengths other than 0 and finite parameters");
  return camera;
}

Result<ColmapImage> colmap_image(std::uint32_t id, std::uint32_t camera_id, const double* pose,
                                 std::string_view name, const fs::path& path,
                                 const std::string& place) {
  const auto view_from_world =
      motion_of_quaternion(Eigen::Quaterniond(pose[0], pose[1], pose[2], pose[3]),
                           Eigen::Vector3d(pose[4], pose[5], pose[6]));
  if (name.empty())
    return bad_input(path, place + "image " + std::to_string(id) + " has no file name");
  if (!view_from_world)
    return bad_input(path, place + "the pose of image " + std::string(name) +
                               " is no rigid motion: its quaternion must have length 1, and its "
                               "numbers must be finite");
  return ColmapImage{id, camera_id, std::string(name), view_from_world->inverse()};
}

bool has_colmap_model(const fs::path& folder) {
  return has_colmap_part(folder / "cameras") && has_colmap_part(folder / "images");
}

Result<ColmapModel> read_colmap_model(const fs::path& folder) {
  auto cameras = read_colmap_part<std::vector<ColmapCamera>>(
      folder / "cameras", parse_colmap_cameras_bin, parse_colmap_cameras_txt);
  if (!cameras) return cameras.error();
  auto images = read_colmap_part<std::vector<ColmapImage>>(
      folder / "images", parse_colmap_images_bin, parse_colmap_images_txt);
  if (!images) return images.error();
  if (auto unique = check_unique_ids(*cameras, "cameras", folder); !unique) return unique.error();
  if (auto unique = check_unique_ids(*images, "images", folder); !unique) return unique.error();
  ColmapModel model{std::move(*cameras), std::move(*images), {}, {}};
  if (!has_colmap_part(folder / "points3D")) return model;
  auto points = read_colmap_part<ColmapPoints>(folder / "points3D", parse_colmap_points_bin,
                                               parse_colmap_points_txt);
  if (!points) return points.error();
  model.points = std::move(points->points);
  model.sightings = std::move(points->sightings);
  return model;
}

}  // namespace relief
