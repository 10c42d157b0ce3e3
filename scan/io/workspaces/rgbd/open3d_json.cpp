#include "scan/io/workspaces/rgbd/open3d_json.h"

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "scan/io/project/json/json_object_private.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The matrix column by column, as Open3D writes it. One that stands row by row is known by the row
// 0 0 1 in its place, and taken as it is meant.
PinholeIntrinsics intrinsics_of_json(JsonObject& camera) {
  Eigen::VectorXd k = camera.numbers("intrinsic_matrix", 9);
  const std::string place = camera.place("intrinsic_matrix");
  Eigen::Map<Eigen::Matrix3d> matrix(k.data());
  if (matrix(2, 0) != 0.0 || matrix(2, 1) != 0.0) matrix.transposeInPlace();
  if (matrix(2, 0) != 0.0 || matrix(2, 1) != 0.0 || matrix(2, 2) != 1.0)
    throw JsonError(place + ": must have the last row 0 0 1");
  if (matrix(0, 1) != 0.0 || matrix(1, 0) != 0.0)
    throw JsonError(place + ": has skew; only fx, fy, cx and cy may differ from 0");
  if (matrix(0, 0) == 0.0 || matrix(1, 1) == 0.0)
    throw JsonError(place + ": a focal length is 0; write fx and fy on its diagonal");
  return {matrix(0, 0), matrix(1, 1), matrix(0, 2), matrix(1, 2)};
}

std::optional<ImageSize> size_of_json(JsonObject& camera) {
  if (!camera.has("width") || !camera.has("height")) return std::nullopt;
  return ImageSize{camera.positive_integer("width"), camera.positive_integer("height")};
}

TrajectoryPose pose_of_json(JsonObject parameters) {
  const Eigen::VectorXd columns = parameters.numbers("extrinsic", 16);
  const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix4d>(columns.data());
  const auto view_from_world =
      rigid_motion_from_matrix(matrix, parameters.place("extrinsic") + " (column by column)");
  if (!view_from_world) throw JsonError(view_from_world.error().message);
  TrajectoryPose pose;
  pose.world_from_view = view_from_world->inverse();
  if (!parameters.has("intrinsic")) return pose;
  JsonObject camera = parameters.object("intrinsic");
  pose.intrinsics = intrinsics_of_json(camera);
  pose.size = size_of_json(camera);
  return pose;
}

}  // namespace

bool looks_like_open3d_camera(std::string_view text) {
  return text.find("\"intrinsic_matrix\"") != std::string_view::npos &&
         !looks_like_open3d_trajectory(text);
}

bool looks_like_open3d_trajectory(std::string_view text) {
  return text.find("\"extrinsic\"") != std::string_view::npos;
}

Result<Calibration> parse_open3d_camera(std::string_view text, const fs::path& path) {
  return read_json<Calibration>(text, path, [](const json& document) {
    JsonObject camera(document, "");
    Calibration calibration;
    calibration.intrinsics = intrinsics_of_json(camera);
    calibration.size = size_of_json(camera);
    if (camera.has("depth_scale")) calibration.depth_scale = camera.positive("depth_scale");
    return calibration;
  });
}

Result<Trajectory> parse_open3d_trajectory(std::string_view text, const fs::path& path) {
  return read_json<Trajectory>(text, path, [](const json& document) {
    JsonObject root(document, "");
    const bool is_list = root.has("parameters");
    Trajectory trajectory;
    if (!is_list) {  // PinholeCameraParameters: a single pose.
      trajectory.push_back(pose_of_json(std::move(root)));
      return trajectory;
    }
    const json& list = root.at("parameters");
    if (!list.is_array()) throw JsonError("parameters: expected a list");
    for (std::size_t i = 0; i < list.size(); ++i)
      trajectory.push_back(
          pose_of_json(JsonObject(list[i], "parameters[" + std::to_string(i) + "]")));
    return trajectory;
  });
}

}  // namespace relief
