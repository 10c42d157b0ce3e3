#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "registration/posegraph/refinement/pair_information.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Scores, the gradients of the negative log likelihood by the poses, summed by cluster: a cluster
/// is a patch of the surface, a cube of a lattice in the world frame. Residuals within a cluster
/// may depend on each other, whichever pairs of views they belong to; a cluster-robust covariance
/// (Liang and Zeger 1986) needs one score per cluster and view.
class ClusterScores {
 public:
  /// Edge of the clusters of on_larger_clusters() over that of the given ones: 32 spacings for 8,
  /// the blocks of docs/results.md, Aligning again. Leaves a sixteenth of the clusters.
  static constexpr double kLarger = 4.0;

  explicit ClusterScores(std::size_t views) : of_view_(views) {}

  /// Patches as on_larger_clusters() joins them, in ascending order of `patch`.
  static PagedVector<PatchScore> larger(std::span<const PatchScore> patches);

  /// Adds the scores of a pair: to its source as they are, to its target with the opposite sign.
  void add(const PairInformation& pair);

  /// The scores of clusters whose edge is kLarger times as long.
  ClusterScores on_larger_clusters() const;

  /// The score of one view on a cluster.
  struct Entry {
    std::size_t view;
    RigidTangent score;
  };
  /// Calls `visit` with each cluster in ascending order, and its entries by view. Looks at the
  /// memory, and for a stop, as loops do (parallel.h).
  void for_each_cluster(
      const std::function<void(std::uint64_t patch, std::span<const Entry>)>& visit) const;

 private:
  std::vector<PagedVector<PatchScore>> of_view_;  // Each in ascending order of `patch`.
};

}  // namespace relief::registration
