#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::fusion {

/// What samples that belong to no surface of their view tell of a filled vertex.
struct ScatteredSamples {
  double offset = 0.0;  ///< Weighted mean of their distances from it along its normal [unit].
  double weight = 0.0;  ///< Their number, each counting t of (F4).
};

/// Dark or grazed parts of an object often return single samples: too few for a surface, and yet
/// they tell where it is. Of each filled vertex of a mesh (`filled` and `normals` set) those that
/// lie nearest to it, within `reach` [unit] of the faces whose vertices all have `wanted` set, and
/// from the side that their view sees. None where there are no such samples. The order of the views
/// does not matter.
std::unordered_map<std::uint32_t, ScatteredSamples> scattered_samples_at(
    const TriangleMesh& mesh, std::span<const std::uint8_t> wanted,
    const std::vector<ViewSampler>& views, double reach);

}  // namespace relief::fusion
