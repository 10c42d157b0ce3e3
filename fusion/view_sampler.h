#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "scan/grid.h"
#include "scan/range_view.h"
#include "scan/result.h"

namespace relief {

/// What one view says about a point of space.
struct Observation {
  /// Signed distance along the surface normal [unit]: positive in front of the surface the view
  /// sees along the point's ray, negative behind it.
  double distance = 0.0;
  /// Confidence x cosine of the viewing angle x ramp from the silhouette, >= 0.
  double weight = 0.0;
  /// No unseen space lies within this distance of the point as far as the view can tell [unit]:
  /// zero behind the surface, growing in front of it and away from the silhouette.
  double clearance = 0.0;
  double range_gap = 0.0;  ///< Distance to where the point's ray meets the surface [unit].
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Of the surface, unit, world frame.
};

struct SamplerOptions {
  /// The weight of a sample grows from the silhouette over this many pixels.
  int silhouette_ramp = 6;
  int threads = 0;
};

/// A range view prepared to be asked for signed distances. Samples are joined into quads along
/// connected grid edges; within a quad, points and normals are interpolated.
class ViewSampler {
 public:
  /// kUnsolvable where points cannot be projected into the view at all.
  static Result<ViewSampler> create(const RangeView& view, const SamplerOptions& options);

  /// Nothing where the point's ray meets no quad.
  std::optional<Observation> observe(const Eigen::Vector3d& point_in_world) const;

  /// The corners of all quads, world frame.
  std::vector<Eigen::Vector3d> surface_points() const;
  bool empty() const { return surface_points_ == 0; }

  /// Median distance between connected neighbours [unit].
  double spacing() const { return spacing_; }
  /// Robust standard deviation of the positions along the normal, from how far each sample is off
  /// the mean of its four neighbours [unit].
  double noise() const { return noise_; }

 private:
  struct Pixel {
    Eigen::Vector3f point = Eigen::Vector3f::Zero();   // relative to centre_
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, facing the sensor
    float weight = 0.0f;
    float border = 0.0f;  // boundary distance [pixels]
    bool quad = false;    // (u, v), (u+1, v), (u, v+1), (u+1, v+1) are one connected surface
    bool corner = false;  // belongs to some quad
  };

  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_view) const;
  double pixel_footprint(const Eigen::Vector3d& point_in_view, double u, double v) const;

  Camera camera_;
  std::optional<RationalProjection> guess_;  // for cameras without a projection of their own
  RigidMotion view_from_world_ = RigidMotion::Identity();
  RigidMotion world_from_view_ = RigidMotion::Identity();
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();  // view frame
  int first_u_ = 0, first_v_ = 0;                     // pixels_ is a crop of the grid
  Grid<Pixel> pixels_;
  std::size_t surface_points_ = 0;
  double spacing_ = 0.0, noise_ = 0.0;
};

}  // namespace relief
