#include "apps/options/input_kind.h"

#include <fstream>
#include <string>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/text_lines.h"

namespace relief {

bool is_triangle_mesh_file(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".obj" || ending == ".stl" || ending == ".vtp") return true;
  if (ending != ".ply") return false;
  std::ifstream file(path, std::ios::binary);
  constexpr int kLongestHeader = 1000;
  std::string line;
  for (int i = 0; i < kLongestHeader && read_line(file, line); ++i) {
    // Writers of clouds, too, declare faces, none of them.
    if (line.starts_with("element face")) return !line.starts_with("element face 0");
    if (line.starts_with("end_header")) return false;
  }
  return false;
}

}  // namespace relief
