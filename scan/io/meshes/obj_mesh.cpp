#include <charconv>
#include <cmath>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

// Reads a Wavefront OBJ: `v` lines, with colours from 0 to 1 behind the coordinates where every
// vertex has one, and `f` lines. Texture, normals, groups and materials are skipped.
class ObjParser {
 public:
  ObjParser(std::string_view content, const std::filesystem::path& path)
      : rest_(content), path_(path) {}

  Result<TriangleMesh> parse() {
    while (!rest_.empty()) {
      ++line_number_;
      std::string_view line = next_line(rest_);
      const std::string_view keyword = next_word(line);
      Result<void> parsed;
      if (keyword == "v") parsed = parse_vertex(line);
      if (keyword == "f") parsed = parse_face(line);
      if (!parsed) return parsed.error();
    }
    if (mesh_.faces.empty()) return bad_input(path_, "no face in the file");
    if (mesh_.colours.size() != mesh_.vertices.size()) mesh_.colours.clear();
    return std::move(mesh_);
  }

 private:
  Error at_line(const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(line_number_) + ": " + what);
  }

  Result<void> parse_vertex(std::string_view line) {
    Eigen::Vector3d vertex;
    for (double& value : vertex)
      if (!parse_number(next_word(line), value) || !std::isfinite(value))
        return at_line("a vertex needs three finite numbers");
    mesh_.vertices.push_back(vertex);
    add_colour(line);
    return {};
  }

  // Three numbers and nothing else; one number would be a weight.
  void add_colour(std::string_view line) {
    Colour colour{};
    for (std::uint8_t& level : colour) {
      double value = 0.0;
      if (!parse_number(next_word(line), value) || !(value >= 0.0 && value <= 1.0)) return;
      level = static_cast<std::uint8_t>(std::lround(255.0 * value));
    }
    if (next_word(line).empty()) mesh_.colours.push_back(colour);
  }

  // Corners are `index`, `index/texture`, `index//normal` or `index/texture/normal`, counted from
  // 1, or backwards from the last vertex when negative.
  Result<void> parse_face(std::string_view line) {
    polygon_.clear();
    for (auto word = next_word(line); !word.empty(); word = next_word(line)) {
      long long index = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
      const auto count = static_cast<long long>(mesh_.vertices.size());
      const bool number = error == std::errc() && (end == word.data() + word.size() || *end == '/');
      if (number && index < 0) index += count + 1;
      if (!number || index < 1 || index > count)
        return at_line("the corner '" + std::string(word.substr(0, 40)) + "' names none of the " +
                       std::to_string(count) + " vertices before it");
      polygon_.push_back(static_cast<std::uint32_t>(index - 1));
    }
    if (polygon_.size() < 3) return at_line("a face needs three corners");
    for (std::size_t k = 1; k + 1 < polygon_.size(); ++k)
      mesh_.faces.push_back({polygon_[0], polygon_[k], polygon_[k + 1]});
    return {};
  }

  std::string_view rest_;
  const std::filesystem::path& path_;
  std::size_t line_number_ = 0;
  TriangleMesh mesh_;
  std::vector<std::uint32_t> polygon_;
};

}  // namespace

Result<TriangleMesh> read_obj_mesh(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  return ObjParser(*content, path).parse();
}

}  // namespace relief
