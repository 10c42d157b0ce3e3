#pragma once

#include <optional>

#include <Eigen/Core>

#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// What a view says of a sample that another one measured.
struct ViewDifference {
  /// Of the sample from the surface that the view measured there, along its normal [unit]; positive
  /// in front of it. Infinite where the view saw through: the sample is no measurement of that
  /// surface, and stands in space seen empty.
  double distance = 0.0;
  double relative_stddev = 1.0;  ///< See Observation.
};

/// Nothing where the view has no surface on the sample's ray, or within `inside` [pixels] of its
/// silhouette. Nothing, too, where the sample is hidden behind the surface or on its other side.
std::optional<ViewDifference> difference_from(const ViewSampler& view,
                                              const Eigen::Vector3d& position,
                                              const Eigen::Vector3d& normal, double inside);

/// So far behind the surface of the view it says nothing of a sample [unit].
double reach_of_difference(const ViewSampler& view);

}  // namespace relief::fusion
