#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "fusion/views/depth_pyramid.h"
#include "fusion/views/paged_surface.h"
#include "fusion/views/range_errors.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/surface/surface_patch.h"
#include "scan/views/view_projection.h"

namespace relief::fusion {

/// What one view says about a point of space.
struct Observation {
  /// Signed distance along the surface normal [unit]: positive in front of the surface the view
  /// sees along the point's ray, negative behind it.
  double distance = 0.0;
  /// Confidence x cosine of the viewing angle x ramp from the silhouette, >= 0.
  double weight = 0.0;
  /// The weight without the ramp: the inverse variance, where the view knows deviations.
  double information = 0.0;
  /// Of the distance, in units of that at the typical range: RangeErrors.
  double relative_stddev = 1.0;
  /// The distance less two standard deviations of it, as far as these are known [unit]: so far the
  /// point surely lies in front of the surface.
  double in_front = 0.0;
  /// No unseen space lies within this distance of the point as far as the view can tell [unit]:
  /// zero behind the surface, growing in front of it and away from the silhouette.
  double clearance = 0.0;
  /// How far behind the surface there is matter as far as the view can tell [unit]: little next to
  /// a silhouette, where the object turns away.
  double matter_depth = 0.0;
  /// The samples are too noisy to tell where the surface is: only that the space before it is
  /// empty.
  bool noisy = false;
  double border = 0.0;     ///< Distance to the silhouette [pixels], interpolated.
  double range_gap = 0.0;  ///< Distance to where the point's ray meets the surface [unit].
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Of the surface, unit, world frame.
};

/// The surface of a range view, prepared to be asked for signed distances: placed in the world,
/// with a pyramid of depths.
class ViewSampler {
 public:
  /// kUnsolvable where points cannot be projected into the view at all.
  static Result<ViewSampler> create(const RangeView& view, const PagedSurfaceOptions& options);

  /// The quad that the ray of a point meets, by its upper left corner, and what each of its corners
  /// counts for.
  struct Quad {
    Eigen::Vector3d point;  ///< View frame.
    Eigen::Vector2d pixel;
    SurfaceQuad corners;  ///< In the crop.
  };
  /// Nothing where the ray meets none.
  std::optional<Quad> quad_on_ray_of(const Eigen::Vector3d& point_in_world) const;

  enum class Side { kInFront, kNear, kBehind };
  /// Whether the point of a quad is farther than `reach` [unit] from the surface on its ray, as far
  /// as the depths of the corners tell.
  Side side(const Quad& quad, double reach) const;

  /// Nothing where the corners' normals have no mean. Where a steep view finds the point of the
  /// quad within `foot_reach` [unit] of its surface, the distance is that to the surface at the
  /// point's foot.
  std::optional<Observation> observe(const Quad& quad, double foot_reach) const;
  /// The same for any point; nothing where its ray meets no quad.
  std::optional<Observation> observe(const Eigen::Vector3d& point_in_world,
                                     double foot_reach) const;

  /// Colour of the surface where the point's ray meets it, 0 to 255; nothing where it meets no quad
  /// or the view has no colours.
  std::optional<Eigen::Vector3d> colour(const Eigen::Vector3d& point_in_world) const;
  bool has_colours() const { return !surface_.colours.empty(); }

  /// False when the view can say nothing of any point of the box: none has a quad on its ray, or
  /// all are farther behind the surface than `reach` [unit].
  bool concerns(const Eigen::AlignedBox3d& box_in_world, double reach) const;

  /// Where the view looks, in the world, of length 1.
  Eigen::Vector3d direction() const { return world_from_view_.linear() * depth_axis_; }

  /// Calls `visit` with the corners of all quads but the noisy ones, world frame, row by row.
  template <typename Visit>
  void for_surface_points(const Visit& visit) const {
    for (int v = 0; v < surface_.marks.height(); ++v)
      for (int u = 0; u < surface_.marks.width(); ++u)
        if (surface_.measured_corner(u, v))
          visit(Eigen::Vector3d(world_from_view_ * (surface_.centre + surface_.offset(u, v))));
  }
  /// Of these corners, world frame; empty when there are none.
  Eigen::AlignedBox3d bounds() const {
    Eigen::AlignedBox3d box;
    for_surface_points([&](const Eigen::Vector3d& point) { box.extend(point); });
    return box;
  }
  /// Calls `visit` with the measured samples that belong to no quad, world frame: single ones, and
  /// patches too small for a surface.
  template <typename Visit>
  void for_scattered_samples(const Visit& visit) const {
    for (const auto& [x, y, z] : surface_.scattered)
      visit(Eigen::Vector3d(world_from_view_ * (surface_.centre + Eigen::Vector3d(x, y, z))));
  }
  bool empty() const { return surface_.pixels.empty(); }

  /// From now on weighs observations by these errors: the weight of Observation is divided by the
  /// relative variance. Sensors without a centre have the same errors at all ranges.
  void set_range_errors(const RangeErrors& errors) {
    errors_ = errors;
    if (has_centre_) largest_relative_stddev_ = errors.relative_stddev(farthest_range_);
  }
  const RangeErrors& range_errors() const { return errors_; }
  /// Of all observations, in units of that at the typical range.
  double largest_relative_stddev() const { return largest_relative_stddev_; }
  /// From the sensor's centre to a point [unit]; 0 where the sensor has none.
  double range_of(const Eigen::Vector3d& point_in_world) const {
    return has_centre_ ? (view_from_world_ * point_in_world).norm() : 0.0;
  }

  /// Size of what is paged under a limit of memory.
  std::size_t bytes() const {
    return surface_.pixels.size() * (sizeof(SurfacePixel) + sizeof(std::uint8_t)) +
           surface_.colours.size() * sizeof(Colour);
  }

  const std::string& name() const { return name_; }
  double spacing() const { return surface_.spacing; }     ///< See PagedSurface.
  double noise() const { return surface_.noise; }         ///< See PagedSurface.
  std::size_t flying() const { return surface_.flying; }  ///< See PagedSurface.
  std::size_t filled() const { return surface_.filled; }  ///< See PagedSurface.
  std::size_t noisy() const { return surface_.noisy; }    ///< See PagedSurface.

 private:
  struct Patch;
  std::optional<Quad> quad_at(const Eigen::Vector3d& point) const;
  std::optional<Patch> patch_on(const Quad& quad) const;

  std::string name_;
  ViewProjection projection_;
  RigidMotion view_from_world_ = RigidMotion::Identity();
  RigidMotion world_from_view_ = RigidMotion::Identity();
  PagedSurface surface_;
  int silhouette_ramp_ = 0;  // [pixels]
  bool has_centre_ = false;  // All rays begin at the origin of the view frame.
  RangeErrors errors_;
  double largest_relative_stddev_ = 1.0;
  double farthest_range_ = 0.0;  // Of the surface, where the sensor has a centre [unit].
  Eigen::Vector3d depth_axis_ = Eigen::Vector3d::UnitZ();  // Mean ray direction, view frame.
  DepthPyramid depths_;  // Of the surface along the axis, from its centre.
};

/// Whether the views look the same way, more or less: nobody saw the back of the object.
bool seen_from_one_side(const std::vector<ViewSampler>& views);

}  // namespace relief::fusion
