#pragma once

#include <string>

#include "apps/reports/report.h"
#include "relief/reconstruction/build_model.h"
#include "relief/scan/mesh_check.h"

namespace relief {

/// The topology of a mesh with the keys that outside tools read, and the counts behind them; where
/// self-intersections were looked for, the number of pairs and the first hundred faces in them.
Json to_json(const MeshCheck& check);

/// The section `merge` of the report, but for its seconds.
Json to_json(const reconstruction::Model& model);

/// Logs how the model was made, `seconds` after the start.
void log_model(const reconstruction::Model& model, const std::string& unit, double seconds);

}  // namespace relief
