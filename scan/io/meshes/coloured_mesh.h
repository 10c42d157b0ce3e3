#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Writes a mesh as binary PLY like write_mesh, with other colours of its vertices and a comment of
/// one line in the header that says what the colours mean.
Result<void> write_coloured_mesh(const TriangleMesh& mesh, std::span<const Colour> colours,
                                 const std::string& comment, const std::filesystem::path& path);

}  // namespace relief
