#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// Two views see the same surface when their normals differ by less than 60 degrees (a cosine); the
/// sides of a plate and the faces of an edge differ by more.
inline constexpr double kSameSurfaceCosine = 0.5;

/// Farther apart than this are two surfaces, not two measurements of one [sample spacings]. More
/// lets steps of the object in; less cuts the differences of views that are badly aligned.
inline constexpr double kFarthest = 8.0;

/// Next to a silhouette samples are mixed with what is behind them [pixels].
inline constexpr double kInside = 2.0;

/// A sample of a view, and its own surface there.
struct ObservedSample {
  Eigen::Vector3d position;  ///< World frame.
  Observation own;
};

/// About `count` samples evenly spread over the view, without those near silhouettes.
std::vector<ObservedSample> some_samples(const ViewSampler& view, std::size_t count);

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
