// Wavefront OBJ, binary STL and binary glTF: small formats that are written in full precision and
// in memory, so that one place sees a disk that is full.
#include <charconv>
#include <cstdint>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "scan/io/files/binary_writer.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

// The shortest text that reads back as the same number.
template <typename T>
void append_number(std::string& text, T value) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, end);
}

template <typename Vector>
void append_line(std::string& text, const char* keyword, const Vector& vector) {
  text += keyword;
  for (const auto value : vector) {
    text += ' ';
    append_number(text, value);
  }
  text += '\n';
}

void append_vector(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float value : vector) append_little_endian(bytes, value);
}

constexpr std::uint32_t kGlbMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kGlbJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kGlbDataChunk = 0x004E4942;  // "BIN"
constexpr int kFloatComponents = 5126, kIndexComponents = 5125;
constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963;

// Describes the three arrays (indices, positions, normals) of the data chunk. Far from the origin
// positions are stored relative to `offset`, which the node adds again.
nlohmann::ordered_json glb_scene(const TriangleMesh& mesh, const Eigen::Vector3d& offset,
                                 const Eigen::AlignedBox3f& box) {
  using json = nlohmann::ordered_json;
  const std::size_t index_bytes = mesh.faces.size() * 12, vector_bytes = mesh.vertices.size() * 12;
  const bool normals = !mesh.normals.empty();
  const auto list = [](const auto& v) { return json{v[0], v[1], v[2]}; };
  json scene;
  scene["asset"] = {{"version", "2.0"}, {"generator", "relief"}};
  scene["scene"] = 0;
  scene["scenes"] = json::array({{{"nodes", json::array({0})}}});
  scene["nodes"] = json::array({{{"mesh", 0}, {"translation", list(offset)}}});
  json primitive = {{"attributes", {{"POSITION", 1}}}, {"indices", 0}, {"mode", 4}};
  if (normals) primitive["attributes"]["NORMAL"] = 2;
  scene["meshes"] = json::array({{{"primitives", json::array({primitive})}}});
  scene["buffers"] =
      json::array({{{"byteLength", index_bytes + vector_bytes * (normals ? 2u : 1u)}}});
  scene["bufferViews"] = json::array(
      {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", index_bytes}, {"target", kIndexBuffer}},
       {{"buffer", 0},
        {"byteOffset", index_bytes},
        {"byteLength", vector_bytes},
        {"target", kVertexBuffer}}});
  scene["accessors"] = json::array({{{"bufferView", 0},
                                     {"componentType", kIndexComponents},
                                     {"count", mesh.faces.size() * 3},
                                     {"type", "SCALAR"}},
                                    {{"bufferView", 1},
                                     {"componentType", kFloatComponents},
                                     {"count", mesh.vertices.size()},
                                     {"type", "VEC3"},
                                     {"min", list(box.min())},
                                     {"max", list(box.max())}}});
  if (!normals) return scene;
  scene["bufferViews"].push_back({{"buffer", 0},
                                  {"byteOffset", index_bytes + vector_bytes},
                                  {"byteLength", vector_bytes},
                                  {"target", kVertexBuffer}});
  scene["accessors"].push_back({{"bufferView", 2},
                                {"componentType", kFloatComponents},
                                {"count", mesh.vertices.size()},
                                {"type", "VEC3"}});
  return scene;
}

}  // namespace

Result<std::string> encode_obj_mesh(const TriangleMesh& mesh) {
  std::string text;
  for (const auto& vertex : mesh.vertices) append_line(text, "v", vertex);
  for (const auto& normal : mesh.normals) append_line(text, "vn", normal);
  for (const auto& face : mesh.faces) {
    text += 'f';
    for (const std::uint32_t vertex : face) {
      text += ' ';
      append_number(text, vertex + 1ull);
      if (mesh.normals.empty()) continue;
      text += "//";
      append_number(text, vertex + 1ull);
    }
    text += '\n';
  }
  return text;
}

Result<std::string> encode_stl_mesh(const TriangleMesh& mesh) {
  std::string bytes = "binary STL, written by relief";
  bytes.resize(80, ' ');
  bytes.reserve(84 + mesh.faces.size() * 50);
  append_little_endian(bytes, static_cast<std::uint32_t>(mesh.faces.size()));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    append_vector(bytes, face_cross(mesh, f).stableNormalized().cast<float>());
    for (int k = 0; k < 3; ++k) append_vector(bytes, mesh.corner(f, k).cast<float>());
    append_little_endian(bytes, std::uint16_t{0});
  }
  return bytes;
}

Result<std::string> encode_glb_mesh(const TriangleMesh& mesh) {
  const std::size_t data_bytes =
      mesh.faces.size() * 12 + (mesh.vertices.size() + mesh.normals.size()) * 12;
  if (data_bytes > 0xf0000000u)
    return Error{ErrorKind::kCannotWrite, "a .glb file cannot exceed 4 GB; use .ply"};
  if (mesh.faces.empty())
    return Error{ErrorKind::kCannotWrite, "a .glb file cannot hold an empty mesh"};
  const Eigen::Vector3d offset =
      needs_doubles(mesh) ? mesh.vertices.front() : Eigen::Vector3d::Zero().eval();
  std::string data;
  data.reserve(data_bytes);
  Eigen::AlignedBox3f box;
  for (const auto& face : mesh.faces)
    for (const std::uint32_t vertex : face) append_little_endian(data, vertex);
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3f stored = (vertex - offset).cast<float>();
    box.extend(stored);
    append_vector(data, stored);
  }
  for (const auto& normal : mesh.normals) append_vector(data, normal);

  std::string scene = glb_scene(mesh, offset, box).dump();
  scene.resize((scene.size() + 3) / 4 * 4, ' ');
  std::string bytes;
  append_little_endian(bytes, kGlbMagic);
  append_little_endian(bytes, std::uint32_t{2});
  append_little_endian(bytes, static_cast<std::uint32_t>(12 + 8 + scene.size() + 8 + data.size()));
  append_little_endian(bytes, static_cast<std::uint32_t>(scene.size()));
  append_little_endian(bytes, kGlbJsonChunk);
  bytes += scene;
  append_little_endian(bytes, static_cast<std::uint32_t>(data.size()));
  append_little_endian(bytes, kGlbDataChunk);
  return bytes + data;
}

}  // namespace relief
