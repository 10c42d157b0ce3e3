#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/global/features/local_features.h"

namespace relief::registration {

/// A point of view a and one of view b that look alike.
struct FeatureMatch {
  Eigen::Index a = 0, b = 0;
};

struct FeatureMatchOptions {
  /// Points of each view that are looked for in the other, evenly spread; > 0. Bounds the time.
  int keys = 400;
  int candidates = 3;  ///< Most similar points that are taken for each; > 0.
  /// For a view with itself: the points of its columns, and how far apart matched ones are at least
  /// [unit].
  const Eigen::Matrix3Xd* own_points = nullptr;
  double least_shift = 0.0;
};

/// Matches both ways between the columns of two sets of features, each once, in a fixed order. Most
/// are wrong.
std::vector<FeatureMatch> match_features(const LocalFeatures& a, const LocalFeatures& b,
                                         const FeatureMatchOptions& options = {});

}  // namespace relief::registration
