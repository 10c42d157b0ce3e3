#include "scan/io/workspaces/rgbd/nerf_transforms.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/project/json/json_object_private.h"
#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"
#include "scan/io/workspaces/rgbd/agreement/pose_scale.h"
#include "scan/io/workspaces/rgbd/agreement/ray_lengths.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kNerfstudioStep = 0.001;  // depth_unit_scale_factor by default [m].

constexpr const char* kDepthKeys[] = {"depth_file_path", "depth_path"};

// The file that a frame names by a key; nothing where it names none, or none that exists.
std::optional<fs::path> file_of(JsonObject& frame, const char* key, const fs::path& folder) {
  if (!frame.has(key)) return std::nullopt;
  const fs::path file = folder / frame.text(key);
  return is_file(file) ? std::optional(file.lexically_normal()) : std::nullopt;
}

std::optional<fs::path> depth_of(JsonObject& frame, const fs::path& folder) {
  for (const char* key : kDepthKeys)
    if (auto file = file_of(frame, key, folder)) return file;
  return std::nullopt;
}

// What the frame says itself goes before what holds for all of them.
std::optional<double> number_of(JsonObject& frame, JsonObject& all, const char* key) {
  for (JsonObject* object : {&frame, &all})
    if (object->has(key)) return object->number(key);
  return std::nullopt;
}

// Of the images, whose size may differ from that of the depth maps.
PinholeIntrinsics image_intrinsics(JsonObject& frame, JsonObject& all, double width,
                                   double height) {
  const auto angle = number_of(frame, all, "camera_angle_x");
  auto fx = number_of(frame, all, "fl_x");
  if (!fx && angle) fx = 0.5 * width / std::tan(0.5 * *angle);
  if (!fx)
    throw JsonError(frame.place("fl_x") +
                    ": missing, for all frames as well; give --intrinsics FX FY CX CY");
  return {*fx, number_of(frame, all, "fl_y").value_or(*fx),
          number_of(frame, all, "cx").value_or(0.5 * width),
          number_of(frame, all, "cy").value_or(0.5 * height)};
}

CameraSpec camera_of(JsonObject& frame, JsonObject& all, const fs::path& depth,
                     const RgbdOptions& options) {
  const auto size = image_size(depth);
  if (!size) throw JsonError(frame.place("depth_file_path") + ": no image that can be read");
  CameraSpec camera;
  camera.width = size->width;
  camera.height = size->height;
  if (options.intrinsics) {
    if (!can_be_intrinsics(*options.intrinsics))
      throw JsonError("the focal lengths FX and FY of --intrinsics must not be 0");
    camera.intrinsics = *options.intrinsics;
    return camera;
  }
  const double width = number_of(frame, all, "w").value_or(size->width);
  const double height = number_of(frame, all, "h").value_or(size->height);
  const PinholeIntrinsics image = image_intrinsics(frame, all, width, height);
  const double x = size->width / width, y = size->height / height;
  camera.intrinsics = {x * image.fx, y * image.fy, x * image.cx - 0.5, y * image.cy - 0.5};
  if (!can_be_intrinsics(camera.intrinsics))
    throw JsonError(frame.place("fl_x") +
                    ": no camera, or of all frames; fl_x, fl_y, w and h must not be 0");
  return camera;
}

bool is_distorted(JsonObject& frame, JsonObject& all) {
  for (const char* key : {"k1", "k2", "k3", "p1", "p2"})
    if (number_of(frame, all, key).value_or(0.0) != 0.0) return true;
  return false;
}

RigidMotion pose_of(JsonObject& frame) {
  Eigen::Matrix4d matrix = frame.matrix4("transform_matrix");
  if (matrix(3, 3) != 0.0) matrix /= matrix(3, 3);
  const auto pose = rigid_motion_from_matrix(matrix, frame.place("transform_matrix"));
  if (!pose) throw JsonError(pose.error().message);
  RigidMotion world_from_view = *pose;
  world_from_view.linear() = world_from_view.linear() * opengl_axes();
  return world_from_view;
}

class Frames {
 public:
  Frames(const json& document, const fs::path& path, const RgbdOptions& options)
      : folder_(path.parent_path()), options_(options), all_(document, "") {}

  ProjectSpec read() {
    project_.unit = "m";
    step_ = stated_step();
    const json& frames = all_.at("frames");
    if (!frames.is_array()) throw JsonError("frames: expected a list");
    for (std::size_t i = 0; i < frames.size(); ++i)
      add(JsonObject(frames[i], "frames[" + std::to_string(i) + "]"));
    if (project_.views.empty())
      throw JsonError(
          "frames: none names a depth map that is there (depth_file_path); relief needs ranges");
    note_losses(frames.size());
    const ComparedDepths compared(project_);
    take_pose_convention(project_, compared, opengl_axes());
    take_ray_lengths(project_, compared);
    take_pose_scale(project_, compared);
    note_disagreement_at_poses(project_, compared);
    return std::move(project_);
  }

 private:
  std::optional<double> stated_step() {
    if (options_.depth_scale) return metres_per_step(*options_.depth_scale);
    if (all_.has("integer_depth_scale"))
      return metres_per_step(all_.positive("integer_depth_scale"));
    return std::nullopt;
  }

  // nerfstudio reads no OpenEXR: these are of other programs, which write metres as real numbers.
  double step_of(const fs::path& depth) {
    if (step_) return *step_;
    const bool real = lower_ending(depth) == ".exr";
    if (!std::exchange(assumed_, true))
      project_.notes.emplace_back(
          real ? "depths are taken as metres; --depth-scale tells another unit"
               : "depths are taken in steps of 0.001 m, as nerfstudio does; --depth-scale tells "
                 "another");
    return real ? 1.0 : kNerfstudioStep;
  }

  void add(JsonObject frame) {
    const auto depth = depth_of(frame, folder_);
    if (!depth) return;
    ViewSpec view;
    view.name = free_view_name(depth->stem().string(),
                               [&](const std::string& name) { return names_.contains(name); });
    names_.insert(view.name);
    view.depth = DepthSpec{*depth, step_of(*depth), false};
    view.camera = camera_of(frame, all_, *depth, options_);
    distorted_ |= is_distorted(frame, all_);
    if (const auto mask = file_of(frame, "mask_path", folder_)) view.mask = ImageFile{*mask};
    if (const auto colour = file_of(frame, "file_path", folder_);
        colour && image_size(*colour) == image_size(*depth))
      view.colour = ImageFile{*colour};
    view.world_from_view = pose_of(frame);
    view.pose = PoseKind::kGuess;
    project_.views.push_back(std::move(view));
  }

  void note_losses(std::size_t frames) {
    if (const std::size_t lost = frames - project_.views.size(); lost > 0)
      project_.notes.push_back(std::to_string(lost) + " of " + std::to_string(frames) +
                               " frames name no depth map that is there, and are left out");
    if (distorted_)
      project_.notes.emplace_back("the distortion of the images (k1, k2, p1, p2) is not applied");
  }

  const fs::path folder_;
  const RgbdOptions& options_;
  JsonObject all_;
  ProjectSpec project_;
  std::set<std::string> names_;
  std::optional<double> step_;  // [m]
  bool assumed_ = false;        // Whether a note tells of the step.
  bool distorted_ = false;
};

}  // namespace

bool looks_like_nerf_transforms(std::string_view text) {
  return text.find("\"transform_matrix\"") != std::string_view::npos &&
         text.find("\"frames\"") != std::string_view::npos;
}

bool is_nerf_folder(const fs::path& folder) {
  if (!is_file(folder / "transforms.json")) return false;
  const auto text = read_file(folder / "transforms.json");
  if (!text || !looks_like_nerf_transforms(*text)) return false;
  return std::any_of(std::begin(kDepthKeys), std::end(kDepthKeys), [&](const char* key) {
    return text->find('"' + std::string(key) + '"') != std::string::npos;
  });
}

Result<ProjectSpec> parse_nerf_transforms(std::string_view text, const fs::path& path,
                                          const RgbdOptions& options) {
  return read_json<ProjectSpec>(
      text, path, [&](const json& document) { return Frames(document, path, options).read(); });
}

}  // namespace relief
