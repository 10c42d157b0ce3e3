#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "registration/global/features/feature_matches.h"
#include "registration/global/features/resampled_view.h"

namespace relief::registration {

struct ConsistencyOptions {
  /// Two matches agree when the distances of their points in the two views differ by no more
  /// [unit].
  double distance_tolerance = 0.0;
  /// Closer ones say nothing of the pose and do not count [unit].
  double least_distance = 0.0;
  /// Largest difference of cosines between the two normals and the line, and of their volume: 12
  /// degrees across the line, (R13).
  double angle_tolerance = 0.2;
};

/// Which matches can be true at once (R13): a graph whose edges join matches that one rigid motion
/// may explain (distance and angles between the two points and normals are alike in both views).
class ConsistencyGraph {
 public:
  ConsistencyGraph(const ResampledView& a, const ResampledView& b,
                   const std::vector<FeatureMatch>& matches, const ConsistencyOptions& options);

  std::size_t size() const { return degrees_.size(); }
  bool consistent(std::size_t i, std::size_t j) const { return (row(i)[j / 64] >> (j % 64)) & 1u; }
  std::size_t degree(std::size_t i) const { return degrees_[i]; }

  /// The edge from `i` whose ends have the most common neighbours, as the set of these and its two
  /// ends, ascending. Wrong matches agree with one another by pairs, hardly ever by three, so this
  /// set is mostly true when `i` is (second-order consistency). Empty without an edge.
  std::vector<std::size_t> consensus_around(std::size_t i) const;

 private:
  const std::uint64_t* row(std::size_t i) const { return bits_.data() + i * words_; }
  void connect(std::size_t i, std::size_t j);

  std::size_t words_ = 0;  // Per row.
  std::vector<std::uint64_t> bits_;
  std::vector<std::size_t> degrees_;
};

}  // namespace relief::registration
