#pragma once

#include <cstdint>
#include <span>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

/// The part of the surface's area in faces with a filled vertex.
double filled_area_fraction(const TriangleMesh& mesh);

/// For each vertex in `set` the first one of its region (those of the set joined by edges); for
/// others themselves.
PagedArray<std::uint32_t> regions_of(const TriangleMesh& mesh, std::span<const std::uint8_t> set);

/// Drops the faces at filled vertices, region by region, of those that have a vertex farther than
/// `largest` [unit] from what was measured (`quality` of filled vertices). Vertices no face uses go
/// as well.
void open_holes(TriangleMesh& mesh, double largest);

}  // namespace relief::fusion
