#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

// The formats behind read_mesh and write_mesh. Readers check that faces name vertices that exist;
// encoders give the bytes of a file.

Result<TriangleMesh> read_ply_mesh(const std::filesystem::path& path);
Result<TriangleMesh> read_obj_mesh(const std::filesystem::path& path);
Result<TriangleMesh> read_stl_mesh(const std::filesystem::path& path);
Result<TriangleMesh> read_vtp_mesh(const std::filesystem::path& path);

/// As write_mesh(), piece by piece: large meshes are written as PLY.
Result<void> write_ply_mesh(const TriangleMesh& mesh, const std::filesystem::path& path);

Result<std::string> encode_vtp_mesh(const TriangleMesh& mesh);
Result<std::string> encode_obj_mesh(const TriangleMesh& mesh);
Result<std::string> encode_stl_mesh(const TriangleMesh& mesh);
Result<std::string> encode_glb_mesh(const TriangleMesh& mesh);
Result<std::string> encode_3mf_mesh(const TriangleMesh& mesh);

/// Whether storing coordinates as 32-bit floats would move a vertex by more than 1e-7 of the size
/// of the mesh: so it does far from the origin.
bool needs_doubles(const TriangleMesh& mesh);

}  // namespace relief
