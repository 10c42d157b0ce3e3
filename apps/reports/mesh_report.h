#pragma once

#include "apps/reports/report.h"
#include "relief/scan/mesh_check.h"

namespace relief {

/// The topology of a mesh with the keys that outside tools read, and the counts behind them; where
/// self-intersections were looked for, the number of pairs and the first hundred faces in them.
Json to_json(const MeshCheck& check);

}  // namespace relief
