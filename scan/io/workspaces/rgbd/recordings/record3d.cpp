#include "scan/io/workspaces/rgbd/recordings/record3d.h"

#include <cstddef>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/project/json/json_object_private.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Pixel centres of K are at halves, as in COLMAP; those of a Calibration at whole numbers.
Calibration calibration_of(JsonObject& metadata) {
  const Eigen::VectorXd k = metadata.numbers("K", 9);
  const double width = metadata.positive_integer("w"), height = metadata.positive_integer("h");
  const ImageSize depth{metadata.positive_integer("dw"), metadata.positive_integer("dh")};
  const double x = depth.width / width, y = depth.height / height;
  Calibration calibration;
  calibration.intrinsics = PinholeIntrinsics{x * k[0], y * k[4], x * k[6] - 0.5, y * k[7] - 0.5};
  if (!can_be_intrinsics(*calibration.intrinsics))
    throw JsonError("K: the focal lengths must not be 0");
  calibration.size = depth;
  return calibration;
}

RigidMotion pose_of(const json& row, const std::string& place) {
  if (!row.is_array() || row.size() != 7)
    throw JsonError(place + ": expected qx qy qz qw tx ty tz");
  Eigen::Matrix<double, 7, 1> n;
  for (std::size_t i = 0; i < 7; ++i) {
    if (!row[i].is_number()) throw JsonError(place + ": expected seven numbers");
    n[static_cast<Eigen::Index>(i)] = row[i].get<double>();
  }
  const Eigen::Quaterniond turn(n[3], n[0], n[1], n[2]);
  if (!(turn.norm() > 0.5)) throw JsonError(place + ": the quaternion has not the length 1");
  RigidMotion pose = RigidMotion::Identity();
  pose.linear() = turn.normalized().toRotationMatrix();
  pose.linear().rightCols<2>() *= -1.0;  // From y up and z back.
  pose.translation() = n.tail<3>();
  return pose;
}

}  // namespace

Result<std::optional<Recording>> read_record3d_metadata(const fs::path& folder) {
  const fs::path path = folder / "metadata.json";
  if (!is_file(path)) return std::optional<Recording>();
  const auto text = read_file(path);
  if (!text) return text.error();
  const json document = json::parse(*text, nullptr, false);
  if (!document.is_object() || !document.contains("K")) return std::optional<Recording>();
  try {
    JsonObject metadata(document, "");
    Recording found;
    found.calibration = calibration_of(metadata);
    found.calibration.notes.push_back("intrinsics from " + path.string());
    if (metadata.has("poses")) {
      const json& poses = metadata.at("poses");
      if (!poses.is_array()) throw JsonError("poses: expected a list");
      for (std::size_t i = 0; i < poses.size(); ++i)
        found.frames[static_cast<int>(i)].world_from_view =
            pose_of(poses[i], "poses[" + std::to_string(i) + "]");
    }
    return std::optional(std::move(found));
  } catch (const JsonError& error) {
    return bad_input(path, error.what());
  }
}

}  // namespace relief
