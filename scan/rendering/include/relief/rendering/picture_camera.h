#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/projections.h"
#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::rendering {

/// A camera in the world, and the part of its grid that a picture shows. Pixel (x, y) of the
/// picture is pixel first + step * (x, y) of the camera; integers are centres of pixels in both.
struct PictureCamera {
  Camera camera;
  RigidMotion world_from_camera = RigidMotion::Identity();
  int width = 0, height = 0;  ///< Of the picture [pixels], >= 1.
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Array2d step = Eigen::Array2d::Ones();  ///< By column and row; not 0.

  /// The ray of a place in the picture, in the world frame.
  Ray ray(double x, double y) const;

  /// Whether the surface can only be at positive ranges: the sensor is at one place. The rays of
  /// other cameras are lines without an end.
  bool rays_start_at_sensor() const;

  /// The directions right, up and towards the viewer in the middle of the picture, as rows:
  /// x_in_picture = picture_axes() * x_in_world for directions x.
  Eigen::Matrix3d picture_axes() const;
};

/// Where the viewer stands round an object whose vertical is `FramingOptions::up`.
struct ViewingDirection {
  /// Round the vertical. 0: for z up at -y, 90: at +x.
  double azimuth_deg = 30.0;
  double elevation_deg = 20.0;  ///< Above the horizontal, in [-90, 90].
  double roll_deg = 0.0;        ///< Turns the camera clockwise about its axis.
};

/// The one from which the viewer stands in the direction `towards_viewer`. Both are unit vectors in
/// the world.
ViewingDirection viewing_direction(const Eigen::Vector3d& towards_viewer,
                                   const Eigen::Vector3d& up);

/// Front, right, back, left, top, bottom.
std::vector<ViewingDirection> six_sides();

/// `count` directions all round, from `first` on, by growing azimuth.
std::vector<ViewingDirection> turntable_directions(const ViewingDirection& first, int count);

struct FramingOptions {
  int width = 1024, height = 768;                 ///< Of the picture [pixels], >= 1.
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< The vertical; a unit vector.
  /// Angle of the longer side of the picture, in [0, 120]; 0: an orthographic camera.
  double field_of_view_deg = 30.0;
  double margin = 0.03;  ///< Left free on each side, as a part of the picture; in [0, 0.5).
};

/// A camera that sees the whole mesh, as large as the picture allows.
PictureCamera frame_mesh(const TriangleMesh& mesh, const ViewingDirection& direction,
                         const FramingOptions& options = {});

/// Cameras for pictures of one series: all at the same distance from the middle of the mesh, so
/// that it keeps its size and its place.
std::vector<PictureCamera> frame_series(const TriangleMesh& mesh,
                                        const std::vector<ViewingDirection>& directions,
                                        const FramingOptions& options = {});

/// The view's own camera at its pose, cut to the view's samples and enlarged or reduced to a
/// picture of at most `width` x `height` pixels. A grid whose rows or columns run the other way, so
/// that it would show a mirror image, is turned over. The whole grid for a view without samples.
PictureCamera frame_view(const RangeView& view, int width, int height);

}  // namespace relief::rendering
