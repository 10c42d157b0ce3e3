#pragma once

#include <string>

#include "apps/commands/command.h"
#include "relief/reconstruction/build_model.h"
#include "relief/scan/result.h"

namespace relief {

/// The model of a project within the memory of the context: its views are read one at a time.
/// `unit` is set to that of the project. kUnsolvable when polishing, which holds all views and the
/// mesh in memory, would exceed it.
Result<reconstruction::Model> merge_within_limit(const ProjectInput& input,
                                                 const reconstruction::ModelOptions& options,
                                                 const Context& context, std::string& unit);

}  // namespace relief
