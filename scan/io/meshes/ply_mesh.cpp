#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "scan/base/parallel.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/binary_writer.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/ply_file.h"
#include "scan/io/meshes/coloured_mesh.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

const PagedVector<double>* scalars(const PlyElement& element, std::string_view name) {
  const PlyProperty* property = element.find(name);
  return property && !property->is_list ? &property->values : nullptr;
}

// Between two of many items, the i-th of which comes next.
void look_at_memory(std::size_t i) {
  constexpr std::size_t kBetweenLooks = 4096;
  if (i % kBetweenLooks == 0) check_stop_and_memory();
}

// Calls take(i) for each vertex, and makes room for a value of each before.
template <typename T, typename Take>
void append(std::size_t count, PagedVector<T>& values, const Take& take) {
  values.reserve(count);
  serial_for(count, [&](std::size_t i) { values.push_back(take(i)); });
}

Result<void> read_vertices(const PlyElement& element, TriangleMesh& mesh,
                           const std::filesystem::path& path) {
  const auto *x = scalars(element, "x"), *y = scalars(element, "y"), *z = scalars(element, "z");
  if (!x || !y || !z) return bad_input(path, "element vertex lacks x, y or z");
  mesh.vertices.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    look_at_memory(i);
    mesh.vertices.emplace_back((*x)[i], (*y)[i], (*z)[i]);
    if (!mesh.vertices.back().allFinite())
      return bad_input(path, "vertex " + std::to_string(i) + " has a NaN or infinite coordinate");
  }
  return {};
}

void read_attributes(const PlyElement& element, TriangleMesh& mesh) {
  const auto *nx = scalars(element, "nx"), *ny = scalars(element, "ny"),
             *nz = scalars(element, "nz");
  const auto whole = [](double value, double max) {
    return value > 0.0 ? std::min(std::floor(value), max) : 0.0;
  };
  const auto byte = [&](double value) { return static_cast<std::uint8_t>(whole(value, 255)); };
  if (nx && ny && nz)
    append(element.count, mesh.normals, [&](std::size_t i) -> Eigen::Vector3f {
      return Eigen::Vector3d((*nx)[i], (*ny)[i], (*nz)[i]).cast<float>();
    });
  if (const auto* quality = scalars(element, "quality"))
    append(element.count, mesh.quality,
           [&](std::size_t i) { return static_cast<float>((*quality)[i]); });
  if (const auto* views = scalars(element, "views"))
    append(element.count, mesh.views,
           [&](std::size_t i) { return static_cast<std::uint16_t>(whole((*views)[i], 65535)); });
  if (const auto* sources = scalars(element, "source_view"))
    append(element.count, mesh.source_views, [&](std::size_t i) {
      return static_cast<std::uint16_t>(whole((*sources)[i], kNoSourceView));
    });
  if (const auto* filled = scalars(element, "filled"))
    append(element.count, mesh.filled,
           [&](std::size_t i) { return static_cast<std::uint8_t>(whole((*filled)[i], 1)); });
  const auto *red = scalars(element, "red"), *green = scalars(element, "green"),
             *blue = scalars(element, "blue");
  if (red && green && blue)
    append(element.count, mesh.colours, [&](std::size_t i) -> Colour {
      return {byte((*red)[i]), byte((*green)[i]), byte((*blue)[i])};
    });
}

const PlyProperty* face_list(const PlyElement& element) {
  for (const char* name : {"vertex_indices", "vertex_index"})
    if (const PlyProperty* property = element.find(name); property && property->is_list)
      return property;
  return nullptr;
}

// Polygons become fans of triangles.
Result<void> read_faces(const PlyElement& element, TriangleMesh& mesh,
                        const std::filesystem::path& path) {
  const PlyProperty* list = face_list(element);
  if (!list) return bad_input(path, "element face has no list property vertex_indices");
  const auto vertex_count = static_cast<double>(mesh.vertices.size());
  mesh.faces.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    look_at_memory(i);
    const std::size_t begin = list->starts[i], end = list->starts[i + 1];
    if (end - begin < 3)
      return bad_input(
          path, "face " + std::to_string(i) + " has " + std::to_string(end - begin) + " corners");
    for (std::size_t k = begin; k < end; ++k)
      if (!(list->values[k] >= 0.0 && list->values[k] < vertex_count))
        return bad_input(path, "face " + std::to_string(i) + ": vertex index " +
                                   std::to_string(static_cast<long long>(list->values[k])) +
                                   " is outside the " + std::to_string(mesh.vertices.size()) +
                                   " vertices");
    const auto corner = [&](std::size_t k) { return static_cast<std::uint32_t>(list->values[k]); };
    for (std::size_t k = begin + 1; k + 1 < end; ++k)
      mesh.faces.push_back({corner(begin), corner(k), corner(k + 1)});
  }
  return {};
}

std::string ply_header(const TriangleMesh& mesh, std::span<const Colour> colours,
                       const std::string& comment, bool doubles) {
  const std::string real = doubles ? "double" : "float";
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  if (!comment.empty()) text += "comment " + comment + "\n";
  text += "element vertex " + std::to_string(mesh.vertices.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) text += "property " + real + " " + axis + "\n";
  if (!mesh.normals.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.quality.empty()) text += "property float quality\n";
  if (!mesh.views.empty()) text += "property ushort views\n";
  if (!mesh.source_views.empty()) text += "property ushort source_view\n";
  if (!mesh.filled.empty()) text += "property uchar filled\n";
  if (!colours.empty()) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  return text + "element face " + std::to_string(mesh.faces.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

// Collects bytes and writes them some at a time.
class Pieces {
 public:
  explicit Pieces(const WritePiece& write) : write_(write) {}

  std::string& bytes() { return bytes_; }
  void write_if_many() {
    constexpr std::size_t kMany = std::size_t{1} << 20;
    if (bytes_.size() >= kMany) write_all();
  }
  Result<void> finish() {
    write_all();
    return written_;
  }

 private:
  void write_all() {
    if (written_) written_ = write_(bytes_);
    bytes_.clear();
  }

  const WritePiece& write_;
  std::string bytes_;
  Result<void> written_;
};

void append_vertex(const TriangleMesh& mesh, std::span<const Colour> colours, bool doubles,
                   std::size_t i, std::string& bytes) {
  for (const double value : mesh.vertices[i]) {
    if (doubles)
      append_little_endian(bytes, value);
    else
      append_little_endian(bytes, static_cast<float>(value));
  }
  if (!mesh.normals.empty())
    for (const float value : mesh.normals[i]) append_little_endian(bytes, value);
  if (!mesh.quality.empty()) append_little_endian(bytes, mesh.quality[i]);
  if (!mesh.views.empty()) append_little_endian(bytes, mesh.views[i]);
  if (!mesh.source_views.empty()) append_little_endian(bytes, mesh.source_views[i]);
  if (!mesh.filled.empty()) append_little_endian(bytes, mesh.filled[i]);
  if (!colours.empty())
    for (const std::uint8_t value : colours[i]) append_little_endian(bytes, value);
}

Result<void> encode(const TriangleMesh& mesh, std::span<const Colour> colours,
                    const std::string& comment, const WritePiece& write) {
  const bool doubles = needs_doubles(mesh);
  Pieces pieces(write);
  pieces.bytes() = ply_header(mesh, colours, comment, doubles);
  serial_for(mesh.vertices.size(), [&](std::size_t i) {
    append_vertex(mesh, colours, doubles, i, pieces.bytes());
    pieces.write_if_many();
  });
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    append_little_endian(pieces.bytes(), std::uint8_t{3});
    for (const std::uint32_t vertex : mesh.faces[f]) append_little_endian(pieces.bytes(), vertex);
    pieces.write_if_many();
  });
  return pieces.finish();
}

}  // namespace

Result<TriangleMesh> read_ply_mesh(const std::filesystem::path& path) {
  const auto ply = read_ply(path);
  if (!ply) return ply.error();
  const PlyElement *vertex = ply->find("vertex"), *face = ply->find("face");
  if (!vertex) return bad_input(path, "no element vertex");
  if (!face)
    return bad_input(path, ply->find("tristrips")
                               ? "triangle strips are not read; convert them to faces"
                               : "no element face: these are points, not a mesh");
  TriangleMesh mesh;
  if (auto vertices = read_vertices(*vertex, mesh, path); !vertices) return vertices.error();
  read_attributes(*vertex, mesh);
  if (auto faces = read_faces(*face, mesh, path); !faces) return faces.error();
  return mesh;
}

Result<void> write_ply_mesh(const TriangleMesh& mesh, const std::filesystem::path& path) {
  return write_in_pieces(
      path, [&](const WritePiece& write) { return encode(mesh, mesh.colours, "", write); });
}

Result<void> write_coloured_mesh(const TriangleMesh& mesh, std::span<const Colour> colours,
                                 const std::string& comment, const std::filesystem::path& path) {
  assert(colours.size() == mesh.vertices.size());
  return write_in_pieces(
      path, [&](const WritePiece& write) { return encode(mesh, colours, comment, write); });
}

}  // namespace relief
