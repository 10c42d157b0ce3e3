#include "scan/io/workspaces/rgbd/recordings/bop_scene.h"

#include <string>
#include <utility>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/project/json/json_object_private.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMillimetre = 1e-3;  // [m]

int number_of_image(const std::string& key) {
  const auto number = frame_number(key);
  if (!number) throw JsonError(key + ": expected the number of an image");
  return *number;
}

// A motion of millimetres, its rotation row by row, as one of metres.
RigidMotion motion_of(JsonObject& record, const std::string& rotation, const std::string& shift) {
  const Eigen::VectorXd r = record.numbers(rotation, 9), t = record.numbers(shift, 3);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data());
  matrix.topRightCorner<3, 1>() = kMillimetre * t;
  const auto motion = rigid_motion_from_matrix(matrix, record.place(rotation));
  if (!motion) throw JsonError(motion.error().message);
  return *motion;
}

RecordedFrame frame_of(JsonObject image) {
  RecordedFrame frame;
  const Eigen::VectorXd k = image.numbers("cam_K", 9);
  frame.intrinsics = PinholeIntrinsics{k[0], k[4], k[2], k[5]};
  if (!can_be_intrinsics(*frame.intrinsics))
    throw JsonError(image.place("cam_K") + ": the focal lengths must not be 0");
  if (image.has("depth_scale")) frame.depth_step = kMillimetre * image.positive("depth_scale");
  if (image.has("cam_R_w2c"))
    frame.world_from_view = motion_of(image, "cam_R_w2c", "cam_t_w2c").inverse();
  return frame;
}

// Poses in the frame of the object, where each image shows one and no pose is known.
bool take_object_poses(const json& truth, Recording& recording) {
  for (const auto& [number, frame] : recording.frames) {
    const auto objects = truth.find(std::to_string(number));
    if (frame.world_from_view || objects == truth.end() || !objects->is_array() ||
        objects->size() != 1)
      return false;
  }
  for (auto& [number, frame] : recording.frames) {
    const std::string key = std::to_string(number);
    JsonObject object(truth[key][0], key + "[0]");
    frame.world_from_view = motion_of(object, "cam_R_m2c", "cam_t_m2c").inverse();
  }
  return true;
}

// A document whose errors are thrown as JsonError; an empty object where the file is not there.
Result<json> read_object(const fs::path& path) {
  if (!is_file(path)) return json::object();
  const auto text = read_file(path);
  if (!text) return text.error();
  json document = json::parse(*text, nullptr, false);
  if (!document.is_object()) return bad_input(path, "is not a JSON object; export it again");
  return document;
}

}  // namespace

Result<std::optional<Recording>> read_bop_scene(const fs::path& folder) {
  const fs::path cameras = folder / "scene_camera.json", objects = folder / "scene_gt.json";
  const auto images = read_object(cameras);
  if (!images) return images.error();
  if (images->empty()) return std::optional<Recording>();
  const auto truth = read_object(objects);
  if (!truth) return truth.error();
  Recording recording;
  recording.calibration.notes.push_back("intrinsics from " + cameras.string());
  try {
    for (const auto& [key, image] : images->items())
      recording.frames[number_of_image(key)] = frame_of(JsonObject(image, key));
  } catch (const JsonError& error) {
    return bad_input(cameras, error.what());
  }
  try {
    if (take_object_poses(*truth, recording))
      recording.calibration.notes.push_back("poses from " + objects.string() +
                                            ", in the frame of the one object of each image");
  } catch (const JsonError& error) {
    return bad_input(objects, error.what());
  }
  return std::optional(std::move(recording));
}

}  // namespace relief
