#include <cstddef>
#include <span>
#include <vector>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/npy_header.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

// How many numbers each matrix of an array has: 12 or 16; 0 for other shapes.
std::size_t matrix_size(const std::vector<std::size_t>& shape) {
  const std::size_t depth = shape.size();
  const bool is_matrix =
      depth >= 2 && shape[depth - 1] == 4 && (shape[depth - 2] == 3 || shape[depth - 2] == 4);
  if (is_matrix && depth <= 3) return 4 * shape[depth - 2];
  return depth == 2 && (shape[1] == 12 || shape[1] == 16) ? shape[1] : 0;
}

}  // namespace

Result<PoseList> parse_npy_poses(std::string_view content, const std::filesystem::path& path) {
  const auto header = read_npy_header(content, path);
  if (!header) return header.error();
  PoseList poses;
  const std::size_t size = matrix_size(header->shape);
  const auto numbers = read_npy_floats(content, *header);
  if (size == 0 || numbers.empty()) return poses;
  const std::size_t count =
      header->shape.size() == 3 || header->shape[1] == size ? header->shape[0] : 1;
  if (numbers.size() / size < count)
    return bad_input(path, "the file ends before its matrices do; it is damaged: save it again");
  for (std::size_t i = 0; i < count; ++i) {
    const auto matrix = std::span(numbers).subspan(i * size, size);
    if (are_lost(matrix)) {
      poses.world_from_view.emplace_back();
      continue;
    }
    const auto motion = motion_of_numbers(matrix, "matrix " + std::to_string(i));
    if (!motion) return bad_input(path, motion.error().message);
    poses.world_from_view.push_back(*motion);
  }
  return poses;
}

}  // namespace relief
