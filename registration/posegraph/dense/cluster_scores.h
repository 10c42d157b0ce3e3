#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "registration/posegraph/dense/pair_information.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What the residuals on each patch of the surface pull each view by, all pairs together: one entry
/// for a patch and a view that sees it, however many pairs meet there.
class ClusterScores {
 public:
  /// Edge of larger patches over that of the patches they are made of.
  static constexpr double kLarger = 4.0;

  explicit ClusterScores(std::size_t views) : of_view_(views) {}

  /// Adds the patches of a pair: to the source as they are, to the target with the other sign.
  void add(const PairInformation& pair);

  /// The same for patches of several times the edge.
  ClusterScores on_larger_clusters() const;

  /// Of one view on one patch.
  struct Entry {
    std::uint64_t patch;
    std::size_t view;
    RigidTangent score;
  };
  /// All, by patch and then by view.
  std::vector<Entry> sorted() const;

 private:
  std::vector<std::unordered_map<std::uint64_t, RigidTangent>> of_view_;
};

}  // namespace relief::registration
