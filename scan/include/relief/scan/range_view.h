#pragma once

#include <limits>
#include <string>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

struct GridEdges;

/// What is known about a view's pose before alignment.
enum class PoseKind {
  kAbsent,  ///< None given; `world_from_view` is the identity.
  kGuess,   ///< A starting point, to be refined.
  kKnown,   ///< Exact; alignment never moves it.
};

/// Where the samples of a view come from.
enum class SampleOrigin {
  kRaw,      ///< The sensor; `deviation`, where there is any, is what the sensor says.
  kRefined,  ///< Ranges solved together with normals: neighbouring samples share their errors.
};

/// The marker of a pixel without a sample.
inline constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();

/// One range scan on its sensor's grid, with what was measured at each pixel. All grids have the
/// size of `camera`; `normals`, `confidence`, `deviation` and `colours` may be empty.
struct RangeView {
  std::string name;
  Camera camera;
  Grid<double> range;             ///< t of equation (V1) [unit]; NaN where there is no sample.
  Grid<Eigen::Vector3f> normals;  ///< Unit, view frame, N . d < 0; NaN: none. Some without range.
  Grid<float> confidence;         ///< >= 0, 1 nominal; empty: 1 everywhere.
  /// Standard deviation of each sample's position along its ray [unit], confidence included; NaN
  /// where unknown, infinite where the position tells nothing; empty: unknown everywhere.
  Grid<float> deviation;
  Grid<Colour> colours;  ///< Empty: none known; without meaning where there is no sample.
  RigidMotion world_from_view = RigidMotion::Identity();
  PoseKind pose = PoseKind::kAbsent;
  SampleOrigin samples = SampleOrigin::kRaw;

  int width() const { return camera.width(); }
  int height() const { return camera.height(); }

  bool has_sample(int u, int v) const { return range.contains(u, v) && range(u, v) == range(u, v); }
  /// The measured point in the view frame; NaN where there is no sample.
  Eigen::Vector3d point(int u, int v) const { return camera.ray(u, v).at(range(u, v)); }

  bool has_normals() const { return !normals.empty(); }
  bool has_normal(int u, int v) const {
    return has_normals() && normals(u, v).x() == normals(u, v).x();
  }
  float confidence_at(int u, int v) const { return confidence.empty() ? 1.0f : confidence(u, v); }

  /// Standard deviation of the position along the ray [unit], NaN where unknown.
  float deviation_at(int u, int v) const {
    return deviation.empty() ? std::numeric_limits<float>::quiet_NaN() : deviation(u, v);
  }

  std::size_t sample_count() const;
};

/// The points of all pixels in the view frame, NaN where there is no sample.
Grid<Eigen::Vector3d> points_of(const RangeView& view);

/// Median distance between samples that are neighbours along a row or column and on one surface
/// [unit]; 0 when no two samples are.
double sample_spacing(const RangeView& view);
/// The same where the points and edges of the view are at hand.
double sample_spacing(const Grid<Eigen::Vector3d>& points, const GridEdges& edges);

}  // namespace relief
