#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What both views of a pair show, as it holds them to each other.
struct PairConstraint {
  std::size_t a = 0, b = 0;
  SharedConstraintSum shared;  ///< World frame, about one centre for all pairs.
};

/// The place and size of views together.
struct ViewsExtent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Mean of their centres; world frame.
  /// Root of the mean square of their radii and of their distances from the centre [unit].
  double radius = 0.0;

  ViewsExtent(const std::vector<std::size_t>& views, const std::vector<ViewSurface>& surfaces,
              const std::vector<RigidMotion>& world_from_view);
};

/// Views that hold each other more firmly than others hold them; or a single view.
struct ViewCluster {
  std::vector<std::size_t> views;   ///< Ascending.
  SharedConstraintSum with_others;  ///< Of all pairs of one of `views` and another view.
};

/// The clusters of views that pairs link, by agglomeration: from single views on, the two clusters
/// are joined whose least correlation (SharedConstraints) is the largest. Gives each cluster on the
/// way that is linked to other views. Of any two, one holds the other or they share no view.
std::vector<ViewCluster> cluster_views(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<PairConstraint>& pairs);

}  // namespace relief::registration
