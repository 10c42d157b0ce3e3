#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

constexpr std::size_t kHeaderBytes = 84, kFaceBytes = 50;

// Joins corners of equal coordinates: STL repeats a vertex in each of its faces.
class CornerJoiner {
 public:
  explicit CornerJoiner(TriangleMesh& mesh) : mesh_(mesh) {}

  std::uint32_t vertex(const Eigen::Vector3f& corner) {
    const Eigen::Vector3f key = corner + Eigen::Vector3f::Zero();  // -0 becomes 0
    const auto [entry, is_new] = known_.try_emplace(
        {std::bit_cast<std::uint32_t>(key.x()), std::bit_cast<std::uint32_t>(key.y()),
         std::bit_cast<std::uint32_t>(key.z())},
        static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(corner.cast<double>());
    return entry->second;
  }

 private:
  using Key = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t hash = 0;
      for (const std::uint32_t word : key) hash = (hash ^ word) * 0x9E3779B97F4A7C15ull;
      return static_cast<std::size_t>(hash ^ (hash >> 32));
    }
  };
  TriangleMesh& mesh_;
  std::unordered_map<Key, std::uint32_t, Hash> known_;
};

std::uint32_t load_word(const char* bytes) {
  const auto* b = reinterpret_cast<const unsigned char*>(bytes);
  return b[0] | static_cast<std::uint32_t>(b[1]) << 8 | static_cast<std::uint32_t>(b[2]) << 16 |
         static_cast<std::uint32_t>(b[3]) << 24;
}

Result<TriangleMesh> parse_binary(std::string_view content, const std::filesystem::path& path) {
  const std::size_t count = load_word(content.data() + 80);
  if (content.size() - kHeaderBytes < count * kFaceBytes)
    return bad_input(path, "truncated: " + std::to_string(count) + " faces promised, room for " +
                               std::to_string((content.size() - kHeaderBytes) / kFaceBytes));
  TriangleMesh mesh;
  mesh.faces.reserve(count);
  CornerJoiner joiner(mesh);
  for (std::size_t f = 0; f < count; ++f) {
    const char* bytes = content.data() + kHeaderBytes + f * kFaceBytes + 12;  // past the normal
    TriangleMesh::Face face{};
    for (std::size_t k = 0; k < 3; ++k) {
      Eigen::Vector3f corner;
      for (int axis = 0; axis < 3; ++axis, bytes += 4)
        corner[axis] = std::bit_cast<float>(load_word(bytes));
      if (!corner.allFinite())
        return bad_input(path, "face " + std::to_string(f) + " has a NaN or infinite coordinate");
      face[k] = joiner.vertex(corner);
    }
    mesh.faces.push_back(face);
  }
  return mesh;
}

Result<TriangleMesh> parse_ascii(std::string_view content, const std::filesystem::path& path) {
  TriangleMesh mesh;
  CornerJoiner joiner(mesh);
  std::vector<std::uint32_t> corners;
  std::size_t line_number = 0;
  const auto error = [&](const char* what) {
    return bad_input(path, "line " + std::to_string(line_number) + ": " + what);
  };
  bool ended = false;
  while (!content.empty()) {
    ++line_number;
    std::string_view line = next_line(content);
    const std::string_view keyword = next_word(line);
    if (keyword == "vertex") {
      Eigen::Vector3d corner;
      for (double& value : corner)
        if (!parse_number(next_word(line), value) || !std::isfinite(static_cast<float>(value)))
          return error("a vertex needs three finite numbers");
      corners.push_back(joiner.vertex(corner.cast<float>()));
    } else if (keyword == "endloop") {
      if (corners.size() != 3) return error("a face needs three corners");
      mesh.faces.push_back({corners[0], corners[1], corners[2]});
      corners.clear();
    }
    ended = keyword == "endsolid" || (ended && keyword.empty());
  }
  if (!ended) return error("the file ends without 'endsolid'; it is truncated");
  return mesh;
}

}  // namespace

Result<TriangleMesh> read_stl_mesh(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  // Binary headers may start with `solid` too: the length decides.
  const bool fits_binary =
      content->size() >= kHeaderBytes &&
      content->size() == kHeaderBytes + kFaceBytes * std::size_t{load_word(content->data() + 80)};
  const bool ascii = !fits_binary && content->starts_with("solid");
  if (!ascii && content->size() < kHeaderBytes) return bad_input(path, "not an STL file");
  auto mesh = ascii ? parse_ascii(*content, path) : parse_binary(*content, path);
  if (mesh && mesh->faces.empty()) return bad_input(path, "no face in the file");
  return mesh;
}

}  // namespace relief
