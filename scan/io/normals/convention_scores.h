#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "scan/io/normals/normal_evidence.h"

namespace relief {

/// What scores say of each of all_conventions.
struct ConventionRanking {
  std::vector<double> disagreement;  ///< See ConventionScores::disagreement().
  /// All that the best one is not clearly better than, itself included; in their order.
  std::vector<std::size_t> candidates;
};

/// How well each of all_conventions agrees with the depth, in parts of views so far from each other
/// that their errors are independent. Two measures, both made such that a bias of up to
/// kLargestBias, which may be the same all over a view, speaks for no convention:
/// - Directions: the angle between patches and stored normals beyond what bias and noise explain.
/// - Relief: the differences of neighbouring patches, in which a smooth bias cancels. It counts
///   only where the stored normals explain the relief of the depth better than a plane would.
class ConventionScores {
 public:
  explicit ConventionScores(NormalFileKind kind) : conventions_(all_conventions(kind)) {}

  /// Adds the parts of one view. Conventions that are impossible for one view drop out.
  void add(const NormalEvidence& evidence);

  /// Index into all_conventions of the one with the least disagreement.
  std::size_t best() const;
  /// Whether `a` agrees so much better than `b` that chance and bias do not explain it.
  bool clearly_better(std::size_t a, std::size_t b) const;
  /// Of all conventions. Goes through all parts for each of them.
  ConventionRanking ranking() const;
  /// The mean of both measures; the lower the better.
  double disagreement(std::size_t convention) const;
  bool possible(std::size_t convention) const;
  std::size_t parts() const { return parts_.size(); }

 private:
  // Sums over the patches and the pairs of patches of a part of a view.
  struct Part {
    Eigen::ArrayXd directions, relief;  // Of the losses, by convention.
    double plane = 0.0;                 // Loss of the relief if there were none.
    double patches = 0.0, pairs = 0.0;
  };
  struct Comparison {
    double deviations = 0.0;  // Mean difference by its standard error.
    bool clear() const;
  };

  template <typename Difference, typename Count>
  Comparison compare(const Difference& difference, const Count& count) const;
  Comparison compare_directions(std::size_t better, std::size_t worse) const;
  Comparison compare_relief(std::size_t better, std::size_t worse) const;
  Comparison compare_with_plane(std::size_t better) const;

  const std::vector<NormalConvention>& conventions_;
  std::vector<Part> parts_;
  std::vector<bool> impossible_;
};

}  // namespace relief
