#pragma once

#include <filesystem>

#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Reads a triangle mesh by its ending: .ply (ASCII, binary of either byte order; polygons are
/// split into fans), .vtp (the same, and triangle strips), .obj, .stl (equal corners are joined).
/// Errors are kBadInput and name file and place.
Result<TriangleMesh> read_mesh(const std::filesystem::path& path);

/// Writes a mesh by the ending of `path`: .ply (binary, doubles where floats would lose more than
/// 1e-7 of the size, with normals, quality, views, filled, colours), .vtp (the same attributes),
/// .obj (with normals and colours), .stl, .glb (normals, colours, the quality as the attribute
/// `_EXPECTED_ERROR`), .3mf (colours; its unit says millimetres). The file appears whole or not at
/// all; errors are kCannotWrite.
Result<void> write_mesh(const TriangleMesh& mesh, const std::filesystem::path& path);

/// Whether write_mesh knows the ending of `path`.
bool is_mesh_path(const std::filesystem::path& path);

}  // namespace relief
