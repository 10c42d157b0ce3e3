#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "registration/global/features/planar_view.h"
#include "registration/global/pair_search.h"
#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Which of the poses that a search by shape found may link their views.
class PairLinks {
 public:
  /// `surfaces`: parts of `whole` ones, or the same (without_dominant_planes()). All must outlive
  /// it; what `options` says at a call holds.
  PairLinks(const std::vector<ViewSurface>& surfaces, const std::vector<ViewSurface>& whole,
            const ViewGroupOptions& options);

  /// Finds the flat faces of all views. To be called before of_pair().
  void find_faces();

  /// Motions by which a view fits itself. Its partners may lie at a second pose then.
  void set_symmetries(std::size_t view, std::vector<RigidMotion> motions);
  bool has_symmetries(std::size_t view) const { return symmetries_[view].has_value(); }

  /// Drops hypotheses that are neither plausible nor right with the support of others. Of views
  /// that are parts, the whole views are refined at what is left, and must be plausible, too.
  /// Whether they are not where the parts fit firmly.
  bool keep_candidates(std::size_t a, std::size_t b, std::vector<PoseHypothesis>& hypotheses,
                       const CoarseScale& scale) const;

  /// The limits of a pose that other pairs confirm.
  VerificationThresholds widest_limits() const;

  /// The links that hypotheses of a pair make, best hypothesis first, with those of the poses that
  /// symmetries lead to from the best one. Poses that samples off the flat faces deny are left
  /// out; where such samples confirm one, so are those for which faces alone speak. So are poses of
  /// a sensor that stood still while something moved before it.
  std::vector<PoseLink> of_pair(std::size_t a, std::size_t b,
                                const std::vector<PoseHypothesis>& found,
                                const CoarseScale& scale) const;

 private:
  std::vector<PoseHypothesis> alternatives(std::size_t a, std::size_t b,
                                           const RigidMotion& b_from_a,
                                           const CoarseScale& scale) const;

  bool may_be_candidate(const PoseEvidence& evidence, const ViewSurface& a,
                        const ViewSurface& b) const;
  bool holds_whole_views(std::size_t a, std::size_t b, PoseHypothesis& hypothesis,
                         const CoarseScale& scale) const;

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<ViewSurface>& whole_;
  const ViewGroupOptions& options_;
  std::vector<FlatFaces> faces_;  // Of each view.
  std::vector<std::optional<std::vector<RigidMotion>>> symmetries_;
};

}  // namespace relief::registration
