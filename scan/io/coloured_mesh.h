#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scan/result.h"
#include "scan/triangle_mesh.h"

namespace relief {

/// Writes a mesh as binary PLY like write_mesh, with a colour (red, green, blue) for each vertex
/// and a comment of one line in the header that says what the colours mean.
Result<void> write_coloured_mesh(const TriangleMesh& mesh,
                                 const std::vector<std::array<std::uint8_t, 3>>& colours,
                                 const std::string& comment, const std::filesystem::path& path);

}  // namespace relief
