#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "registration/posegraph/refinement/pair_information.h"
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
  static std::vector<PatchScore> larger(const std::vector<PatchScore>& patches);

  /// Adds the scores of a pair: to its source as they are, to its target with the opposite sign.
  void add(const PairInformation& pair);

  /// The scores of clusters whose edge is kLarger times as long.
  ClusterScores on_larger_clusters() const;

  /// The score of one view on one cluster.
  struct Entry {
    std::uint64_t patch;
    std::size_t view;
    RigidTangent score;
  };
  /// All entries, by patch and then by view.
  std::vector<Entry> sorted() const;

 private:
  std::vector<std::unordered_map<std::uint64_t, RigidTangent>> of_view_;
};

}  // namespace relief::registration
