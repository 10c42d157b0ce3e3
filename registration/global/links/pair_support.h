#pragma once

#include <cstddef>
#include <vector>

#include "registration/global/judged_pairs.h"
#include "registration/global/links/link_index.h"
#include "registration/global/links/link_limits.h"
#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Whether two poses of a view are one: its samples move by less than 0.15 of its radius.
bool same_place(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y);

/// What single pairs of views say for or against a way of joining two groups.
class PairSupport {
 public:
  /// `surfaces`, `links` (those that are believed), `options` and `judged` outlive this.
  PairSupport(const std::vector<ViewSurface>& surfaces, const std::vector<PoseLink>& links,
              const LinkLimits& limits, const ViewGroupOptions& options, JudgedPairs& judged)
      : surfaces_(surfaces), index_(links), limits_(limits), options_(options), judged_(judged) {}

  /// What view j says for a pose relative to view i: their overlap where it is within its limits,
  /// less than 0 where it is not, by how far; 0 where they hardly meet. Poses that follow from
  /// chains of links are a little off: the pair may settle before it is judged. Minus infinity for
  /// one that settles elsewhere.
  double support(std::size_t i, std::size_t j, const RigidMotion& i_from_j) const;

 private:
  double support_of(const PoseEvidence& evidence, bool linked) const;
  const PoseLink* link_at(std::size_t i, std::size_t j, const RigidMotion& i_from_j) const;

  const std::vector<ViewSurface>& surfaces_;
  const LinkIndex index_;
  const LinkLimits limits_;
  const ViewGroupOptions& options_;
  JudgedPairs& judged_;
};

}  // namespace relief::registration
