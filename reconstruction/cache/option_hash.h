#pragma once

#include "registration/units/align_units.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/cross_view_consistency.h"
#include "relief/registration/pair_fit.h"
#include "scan/units/content_hash.h"

// All fields of the options of the stages that may change a result: not the numbers of threads,
// nor the limits of memory. Those of aligning and
// merging are in align_units.h and merge_units.h.

namespace relief::registration {

void hash_into(ContentHash& hash, const DegenerateDirection& direction);
void hash_into(ContentHash& hash, const PairFit& pair);

}  // namespace relief::registration

namespace relief::hybrid {

void hash_into(ContentHash& hash, const RefineOptions& options);
void hash_into(ContentHash& hash, const MeshNormalOptions& options);
void hash_into(ContentHash& hash, const PolishOptions& options);

}  // namespace relief::hybrid

namespace relief::reconstruction {

void hash_into(ContentHash& hash, const CrossViewOptions& options);

}  // namespace relief::reconstruction
