#include "relief/io/mesh_io.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "scan/base/parallel.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

template <Result<std::string> (*Encode)(const TriangleMesh&)>
Result<void> write_encoded(const TriangleMesh& mesh, const std::filesystem::path& path) {
  const auto bytes = Encode(mesh);
  if (!bytes) return cannot_write(path, bytes.error().message);
  return write_file(path, *bytes);
}

using Writer = Result<void> (*)(const TriangleMesh&, const std::filesystem::path&);

Writer writer_of(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".ply") return write_ply_mesh;
  if (ending == ".vtp") return write_encoded<encode_vtp_mesh>;
  if (ending == ".obj") return write_encoded<encode_obj_mesh>;
  if (ending == ".stl") return write_encoded<encode_stl_mesh>;
  if (ending == ".glb") return write_encoded<encode_glb_mesh>;
  if (ending == ".3mf") return write_encoded<encode_3mf_mesh>;
  return nullptr;
}

}  // namespace

bool is_mesh_path(const std::filesystem::path& path) { return writer_of(path) != nullptr; }

bool needs_doubles(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  double largest = 0.0;
  serial_for(mesh.vertices.size(), [&](std::size_t v) {
    const Eigen::Vector3d& vertex = mesh.vertices[v];
    box.extend(vertex);
    largest = std::max(largest, (vertex - vertex.cast<float>().cast<double>()).norm());
  });
  return !box.isEmpty() && largest > 1e-7 * box.diagonal().norm();
}

Result<TriangleMesh> read_mesh(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".ply") return read_ply_mesh(path);
  if (ending == ".obj") return read_obj_mesh(path);
  if (ending == ".stl") return read_stl_mesh(path);
  if (ending == ".vtp") return read_vtp_mesh(path);
  return bad_input(path, "unknown mesh format '" + ending + "'; use .ply, .vtp, .obj or .stl");
}

Result<void> write_mesh(const TriangleMesh& mesh, const std::filesystem::path& path) {
  const Writer write = writer_of(path);
  if (!write)
    return cannot_write(path, "unknown mesh format '" + lower_ending(path) +
                                  "'; use .ply, .vtp, .obj, .stl, .glb or .3mf");
  return write(mesh, path);
}

}  // namespace relief
