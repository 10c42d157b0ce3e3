#include "scan/io/grids/grid_file.h"

#include <fstream>
#include <string>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"

namespace relief {

bool has_grid_ending(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".ply" || ending == ".pcd";
}

bool is_grid_file(const std::filesystem::path& path) {
  if (lower_ending(path) == ".pcd") return true;
  if (lower_ending(path) != ".ply") return false;
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int lines = 0; lines < 1000 && read_line(file, line); ++lines) {
    if (line.starts_with("element range_grid") || line.starts_with("obj_info num_cols"))
      return true;
    if (line.starts_with("end_header")) return false;
  }
  return false;
}

Result<GridFile> read_grid_file(const std::filesystem::path& path) {
  if (lower_ending(path) == ".ply") return read_ply_grid(path);
  if (lower_ending(path) == ".pcd") return read_pcd_grid(path);
  return bad_input(path, "unknown grid format '" + path.extension().string() +
                             "'; use a range-grid .ply or an organized .pcd");
}

}  // namespace relief
