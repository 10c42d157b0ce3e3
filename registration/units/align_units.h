#pragma once

#include <string>
#include <vector>

#include "registration/global/pair_search.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "relief/registration/align_options.h"
#include "relief/registration/calibrate_views.h"
#include "relief/scan/range_view.h"
#include "relief/scan/unit_store.h"
#include "scan/units/content_hash.h"

namespace relief::registration {

void hash_into(ContentHash& hash, const ViewSurfaceOptions& options);
void hash_into(ContentHash& hash, const StartingPoseOptions& options);
void hash_into(ContentHash& hash, const JointRefinementOptions& options);
void hash_into(ContentHash& hash, const AlignOptions& options);
void hash_into(ContentHash& hash, const CalibrationOptions& options);

/// The parts of an alignment that are kept as units of work. Each function gives what the function
/// without a store gives, to the bit.
class AlignUnits {
 public:
  /// Keeps nothing.
  AlignUnits() = default;
  /// `surface`: how the surfaces of `views` are made. `store` may be null.
  AlignUnits(UnitStore* store, const std::vector<RangeView>& views,
             const ViewSurfaceOptions& surface);

  /// registration::refine_jointly of the surfaces of all views.
  Result<JointRefinement> refine_jointly(const std::vector<ViewSurface>& surfaces,
                                         const std::vector<RigidMotion>& world_from_view,
                                         const std::vector<ViewRole>& roles,
                                         const JointRefinementOptions& options,
                                         const Progress& progress) const;

  /// registration::search_pair of the views a and b of `views`.
  std::vector<PoseHypothesis> search_pair(const std::vector<CoarseView>& views, std::size_t a,
                                          std::size_t b, const CoarseScale& scale,
                                          const PairSearchOptions& options) const;

  /// registration::partial_symmetries of the view i.
  std::vector<RigidMotion> partial_symmetries(const CoarseView& view, std::size_t i,
                                              const CoarseScale& scale,
                                              const VerificationThresholds& limits,
                                              const PairSearchOptions& options) const;

 private:
  std::string key_of(const CoarseView& view, std::size_t i) const;

  UnitStore* store_ = nullptr;
  std::vector<std::string> surfaces_;  // Hashes of all that the surface of a view depends on.
};

}  // namespace relief::registration
