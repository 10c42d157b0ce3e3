#pragma once

#include "scan/io/project/view_spec.h"

namespace relief {

/// Notes where the scans of PTX files are, so that each is read without those before it. Where all
/// such views but one have a matrix, the others were registered to that one: its identity is its
/// pose, with a note. Files that cannot be read stay as they are: their reader says why.
void complete_ptx_views(ProjectSpec& project);

}  // namespace relief
