#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fusion/holes/fair_regions.h"
#include "fusion/views/view_sampler.h"
#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Moves the filled vertices of a merged mesh (`filled` and `normals` set) to where
/// fair_filled_regions() has them, unless that would break what `check` says of the mesh. Regions
/// near samples are faired twice. Gives notes on what stays as the closed field has it. Errors: as
/// fair_filled_regions().
Result<std::vector<std::string>> fair_holes(const FairFillOptions& options,
                                            const std::vector<ViewSampler>& views,
                                            TriangleMesh& mesh, MeshCheck& check,
                                            const Progress& progress = {});

}  // namespace relief::fusion
