#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

// How many numbers each pose of an array has: 7, or 12 or 16 of a matrix; 0 for other shapes.
std::size_t pose_size(const std::vector<std::size_t>& shape) {
  const std::size_t depth = shape.size();
  const bool is_matrix =
      depth >= 2 && shape[depth - 1] == 4 && (shape[depth - 2] == 3 || shape[depth - 2] == 4);
  if (is_matrix && depth <= 3) return 4 * shape[depth - 2];
  const bool is_rows = depth == 2 && (shape[1] == 7 || shape[1] == 12 || shape[1] == 16);
  return is_rows ? shape[1] : 0;
}

Result<RigidMotion> motion_of(std::span<const double> numbers, std::size_t index) {
  if (numbers.size() != 7) return motion_of_numbers(numbers, "matrix " + std::to_string(index));
  const auto motion =
      motion_of_quaternion(Eigen::Quaterniond(numbers[6], numbers[3], numbers[4], numbers[5]),
                           Eigen::Vector3d(numbers[0], numbers[1], numbers[2]));
  if (motion) return *motion;
  return Error{ErrorKind::kBadInput,
               "row " + std::to_string(index) +
                   " is not a rigid motion: its quaternion qx qy qz qw must have length 1"};
}

}  // namespace

Result<PoseList> parse_npy_poses(std::string_view content, const std::filesystem::path& path) {
  const auto header = read_npy_header(content, path);
  if (!header) return header.error();
  PoseList poses;
  const std::size_t size = pose_size(header->shape);
  const auto numbers = read_npy_floats(content, *header);
  if (size == 0 || numbers.empty()) return poses;
  const std::size_t count =
      header->shape.size() == 3 || header->shape[1] == size ? header->shape[0] : 1;
  if (numbers.size() / size < count)
    return bad_input(path, "the file ends before its poses do; it is damaged: save it again");
  for (std::size_t i = 0; i < count; ++i) {
    const auto of_pose = std::span(numbers).subspan(i * size, size);
    if (are_lost(of_pose)) {
      poses.world_from_view.emplace_back();
      continue;
    }
    const auto motion = motion_of(of_pose, i);
    // The seven joints of an arm are as many numbers.
    if (!motion && size == 7 && i == 0) return PoseList();
    if (!motion) return bad_input(path, motion.error().message);
    poses.world_from_view.push_back(*motion);
  }
  return poses;
}

}  // namespace relief
