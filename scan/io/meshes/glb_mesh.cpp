// Binary glTF 2.0. The one file that meets tinygltf.
#include <cmath>
#include <cstdint>
#include <sstream>

#include <Eigen/Geometry>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_INCLUDE_JSON
#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "scan/base/srgb.h"
#include "scan/io/files/binary_writer.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

// The data of a glTF file: arrays one behind the other in one buffer.
class GltfArrays {
 public:
  // Values of 4 bytes, or 4 of 2 bytes, each: every array starts at a multiple of 4 as is demanded.
  int add(const std::string& bytes, int component_type, int type, std::size_t count, int target) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = data_.size();
    view.byteLength = bytes.size();
    view.target = target;
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size());
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    data_.insert(data_.end(), bytes.begin(), bytes.end());
    model_.bufferViews.push_back(std::move(view));
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  tinygltf::Accessor& last() { return model_.accessors.back(); }

  tinygltf::Model finish() {
    model_.buffers.emplace_back().data = std::move(data_);
    return std::move(model_);
  }

 private:
  tinygltf::Model model_;
  std::vector<unsigned char> data_;
};

std::string index_bytes_of(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(12 * mesh.faces.size());
  for (const auto& face : mesh.faces)
    for (const std::uint32_t vertex : face) append_little_endian(bytes, vertex);
  return bytes;
}

void add_positions(const TriangleMesh& mesh, const Eigen::Vector3d& offset, GltfArrays& arrays,
                   tinygltf::Primitive& primitive) {
  std::string bytes;
  bytes.reserve(12 * mesh.vertices.size());
  Eigen::AlignedBox3f box;
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3f stored = (vertex - offset).cast<float>();
    box.extend(stored);
    for (const float value : stored) append_little_endian(bytes, value);
  }
  primitive.attributes["POSITION"] =
      arrays.add(bytes, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, mesh.vertices.size(),
                 TINYGLTF_TARGET_ARRAY_BUFFER);
  arrays.last().minValues = {box.min().x(), box.min().y(), box.min().z()};
  arrays.last().maxValues = {box.max().x(), box.max().y(), box.max().z()};
}

// glTF has linear colours; those of a mesh are sRGB.
std::uint16_t linear_of_srgb(std::uint8_t value) {
  return static_cast<std::uint16_t>(std::lround(65535.0 * linear_from_srgb(value / 255.0)));
}

void add_colours(const TriangleMesh& mesh, GltfArrays& arrays, tinygltf::Primitive& primitive) {
  std::string bytes;
  bytes.reserve(8 * mesh.colours.size());
  for (const Colour& colour : mesh.colours) {
    for (const std::uint8_t value : colour) append_little_endian(bytes, linear_of_srgb(value));
    append_little_endian(bytes, std::uint16_t{65535});
  }
  primitive.attributes["COLOR_0"] =
      arrays.add(bytes, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4,
                 mesh.colours.size(), TINYGLTF_TARGET_ARRAY_BUFFER);
  arrays.last().normalized = true;
}

void add_attributes(const TriangleMesh& mesh, GltfArrays& arrays, tinygltf::Primitive& primitive) {
  if (!mesh.normals.empty()) {
    std::string bytes;
    bytes.reserve(12 * mesh.normals.size());
    for (const auto& normal : mesh.normals)
      for (const float value : normal) append_little_endian(bytes, value);
    primitive.attributes["NORMAL"] =
        arrays.add(bytes, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, mesh.normals.size(),
                   TINYGLTF_TARGET_ARRAY_BUFFER);
  }
  if (!mesh.colours.empty()) add_colours(mesh, arrays, primitive);
  if (mesh.quality.empty()) return;
  std::string bytes;
  bytes.reserve(4 * mesh.quality.size());
  for (const float value : mesh.quality) append_little_endian(bytes, value);
  // Names of an application's own attributes begin with an underscore.
  primitive.attributes["_EXPECTED_ERROR"] =
      arrays.add(bytes, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, mesh.quality.size(),
                 TINYGLTF_TARGET_ARRAY_BUFFER);
}

tinygltf::Model gltf_model(const TriangleMesh& mesh) {
  // Far from the origin positions are stored relative to a vertex, which the node adds again.
  const Eigen::Vector3d offset =
      needs_doubles(mesh) ? mesh.vertices.front() : Eigen::Vector3d::Zero().eval();
  GltfArrays arrays;
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.indices =
      arrays.add(index_bytes_of(mesh), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                 3 * mesh.faces.size(), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  add_positions(mesh, offset, arrays, primitive);
  add_attributes(mesh, arrays, primitive);
  tinygltf::Model model = arrays.finish();
  model.asset.version = "2.0";
  model.asset.generator = "relief";
  model.meshes.emplace_back().primitives.push_back(std::move(primitive));
  tinygltf::Node& node = model.nodes.emplace_back();
  node.mesh = 0;
  node.translation = {offset.x(), offset.y(), offset.z()};
  model.scenes.emplace_back().nodes = {0};
  model.defaultScene = 0;
  return model;
}

}  // namespace

Result<std::string> encode_glb_mesh(const TriangleMesh& mesh) {
  constexpr std::size_t kLargest = 0xf0000000u;  // a length field has 32 bits
  const std::size_t vertex_bytes = 12 + (mesh.normals.empty() ? 0 : 12) +
                                   (mesh.colours.empty() ? 0 : 8) + (mesh.quality.empty() ? 0 : 4);
  if (mesh.faces.size() * 12 + mesh.vertices.size() * vertex_bytes > kLargest)
    return Error{ErrorKind::kCannotWrite, "a .glb file cannot exceed 4 GB; use .ply"};
  if (mesh.faces.empty())
    return Error{ErrorKind::kCannotWrite, "a .glb file cannot hold an empty mesh"};
  tinygltf::Model model = gltf_model(mesh);
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, stream, /*prettyPrint=*/false, /*writeBinary=*/true))
    return Error{ErrorKind::kCannotWrite, "the glTF writer failed"};
  return std::move(stream).str();
}

}  // namespace relief
