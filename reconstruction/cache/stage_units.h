#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/fusion/field_part.h"
#include "relief/fusion/merge_views.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/cross_view_consistency.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "relief/registration/search_pairs.h"

namespace relief::reconstruction {

/// The error that a function below gives where it would have to compute a unit; nothing: it
/// computes.
using MissingUnitError = std::optional<Error>;

// The stages as units of work: what the store of the context holds is not computed again. Each
// gives what the function of the stage gives, to the bit, and its errors.

/// registration::align_views. `kind` tells the first alignment from the second.
Result<registration::Alignment> align_or_find(std::string_view kind,
                                              const std::vector<RangeView>& views,
                                              const registration::AlignOptions& options,
                                              const Context& context,
                                              const MissingUnitError& otherwise = {});

/// registration::search_pairs: besides the pairs that a block was searched is a unit.
Result<std::size_t> search_or_find(const std::vector<RangeView>& views,
                                   const registration::AlignOptions& options,
                                   const registration::PairBlock& block, const Context& context,
                                   const MissingUnitError& otherwise = {});

/// registration::calibrate_views.
Result<registration::SensorCalibration> calibrate_or_find(
    const std::vector<RangeView>& views, const registration::Alignment& aligned,
    const registration::AlignOptions& align, const registration::CalibrationOptions& options,
    const Context& context, const MissingUnitError& otherwise = {});

/// weigh_by_consistency.
Result<std::vector<ViewConsistency>> weigh_or_find(const std::vector<registration::PairFit>& pairs,
                                                   const CrossViewOptions& options,
                                                   std::vector<RangeView>& views,
                                                   const Context& context,
                                                   const MissingUnitError& otherwise = {});

/// hybrid::refine_views: a unit for each view, which does not depend on its pose and name. Each is
/// kept as soon as it is finished.
Result<std::vector<hybrid::RefinedView>> refine_or_find(const std::vector<RangeView>& views,
                                                        const hybrid::RefineOptions& options,
                                                        const Context& context,
                                                        const MissingUnitError& otherwise = {});

/// fusion::compute_field_part: besides the results of the part, that it was computed is a unit.
Result<std::size_t> field_part_or_find(const std::vector<RangeView>& views,
                                       const fusion::MergeOptions& options,
                                       const fusion::FieldPart& part, const Context& context,
                                       const MissingUnitError& otherwise = {});

/// fusion::merge_views. `hashes`: hashes_of_views, where there is a store.
Result<fusion::MergeResult> merge_or_find(const std::vector<std::string>& hashes,
                                          const std::vector<RangeView>& views,
                                          const fusion::MergeOptions& options,
                                          const Context& context,
                                          const MissingUnitError& otherwise = {});

/// hybrid::polish_mesh. `hashes` as above.
Result<hybrid::PolishedMesh> polish_or_find(const std::vector<std::string>& hashes,
                                            const TriangleMesh& mesh,
                                            const std::vector<RangeView>& views,
                                            const hybrid::PolishOptions& options,
                                            const Context& context,
                                            const MissingUnitError& otherwise = {});

}  // namespace relief::reconstruction
