#include "apps/options/input_kind.h"

#include <fstream>
#include <string>

namespace relief {

bool is_triangle_mesh_file(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".obj" || ending == ".stl" || ending == ".vtp") return true;
  if (ending != ".ply") return false;
  std::ifstream file(path, std::ios::binary);
  constexpr int kLongestHeader = 1000;
  std::string line;
  for (int i = 0; i < kLongestHeader && std::getline(file, line); ++i) {
    if (line.starts_with("element face")) return true;
    if (line.starts_with("end_header")) return false;
  }
  return false;
}

}  // namespace relief
