#pragma once

#include <filesystem>

namespace relief {

/// Whether a file holds a triangle mesh: an .obj, .stl or .vtp by its ending, a .ply by the faces
/// that its header declares (a range grid declares none). False for what cannot be opened.
bool is_triangle_mesh_file(const std::filesystem::path& path);

}  // namespace relief
