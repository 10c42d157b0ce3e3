#pragma once

#include "apps/report.h"
#include "scan/mesh_check.h"

namespace relief {

/// The topology of a mesh with the keys that outside tools read, and the counts behind them.
Json to_json(const MeshCheck& check);

}  // namespace relief
