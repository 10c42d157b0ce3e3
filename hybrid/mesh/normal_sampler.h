#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/surface/range_surface.h"
#include "scan/views/view_projection.h"

namespace relief::hybrid {

/// What one view says about the normal at a vertex.
struct NormalObservation {
  Eigen::Vector3d normal;  ///< World frame, of length 1.
  double weight;
};

/// The surface of a view with its measured normals, placed in the world. The view must outlive it.
class NormalSampler {
 public:
  NormalSampler(const RangeView& view, ViewProjection projection, int silhouette_ramp);

  double spacing() const { return surface_.spacing(); }

  /// Nothing where the view sees no surface within `max_distance` [unit] of the vertex that faces
  /// as the mesh does there.
  std::optional<NormalObservation> at(const Eigen::Vector3d& vertex,
                                      const Eigen::Vector3d& mesh_normal,
                                      double max_distance) const;

  /// False where at() has nothing at any point of the box (world frame).
  bool concerns(const Eigen::AlignedBox3d& box, double max_distance) const;

 private:
  RangeSurface surface_;
  ViewProjection projection_;
  RigidMotion view_from_world_;
  Eigen::AlignedBox3d bounds_;  // Of the samples, in the world.
};

/// Of the views that have normals, samples and a pose. kBadInput where one has no projection.
Result<std::vector<NormalSampler>> normal_samplers(const std::vector<RangeView>& views,
                                                   int silhouette_ramp);

/// Samplers by their indices.
using NearViews = std::vector<std::size_t>;

/// Those that concern a box.
NearViews views_near(const Eigen::AlignedBox3d& box, const std::vector<NormalSampler>& samplers,
                     double max_distance);

}  // namespace relief::hybrid
