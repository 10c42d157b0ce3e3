#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "relief/registration/calibrate_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// The sensor of some views as a linear model of what its calibration may have wrong (C1): term k
/// moves the sample of a pixel by `c_k` times a vector field of the view frame. Every field is
/// scaled to a root mean square of one sample spacing over the samples of the sensor's views, so
/// that coefficients of all terms compare.
class SensorModel {
 public:
  /// `views`: those of the sensor, at least one, with the same camera model. `spacing`: their
  /// sample spacing [unit].
  SensorModel(const std::vector<const RangeView*>& views, double spacing);

  std::size_t terms() const { return terms_.size(); }
  SensorError error_of(std::size_t term) const { return terms_[term].error; }
  double spacing() const { return spacing_; }
  /// Whether a scale of the ranges is one of the whole view: all rays start from one point.
  bool scales_all() const { return from_centre_; }

  /// What each term moves the point that a view has at a pixel and range by along a unit normal of
  /// the view frame, for a coefficient of 1 [unit].
  void project(const RangeView& view, const Eigen::Vector2d& pixel, double range,
               const Eigen::Vector3d& normal, std::span<double> along_normal) const;

  /// The view with errors of these coefficients undone: its samples move by the sum of the fields.
  /// Ranges change, and the camera where an error of the camera has a coefficient.
  RangeView corrected(const RangeView& view, std::span<const double> coefficients) const;

  /// The sum of the range terms at a pixel [unit], along the ray.
  double range_correction(const RangeView& view, const Eigen::Vector2d& pixel, double range,
                          std::span<const double> coefficients) const;

  /// The coefficient of a term in units of its own: a length for offset and warp, a ratio for scale
  /// and focal length, pixels for principal point and interlacing, Brown's for distortion, 1 for
  /// ray lengths.
  double natural(std::size_t term, double coefficient) const {
    return coefficient * terms_[term].scale;
  }

 private:
  // What a term is within its error: powers of the pixel coordinates of a warp, or which of the
  // parameters of the camera.
  struct Term {
    SensorError error;
    int i = 0, j = 0;
    double scale = 1.0;  // Natural units per coefficient.
  };
  // A sample, with what all terms need of it.
  struct Place;

  Place place(const RangeView& view, const Eigen::Vector2d& pixel, double range) const;
  Eigen::Vector3d field(const Term& term, const Place& place) const;
  double range_field(const Term& term, const Place& place) const;
  Eigen::Vector3d camera_field(const Term& term, const Place& place) const;
  void list_terms(const Camera& camera);
  void measure_extent(const std::vector<const RangeView*>& views);
  void scale_terms(const std::vector<const RangeView*>& views);

  std::vector<Term> terms_;
  double spacing_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();     // Of the samples' pixels.
  Eigen::Vector2d half_size_ = Eigen::Vector2d::Ones();  // [pixels]
  double reference_range_ = 0.0;                         // Mean of the samples'.
  bool from_centre_ = false;                             // Whether all rays start from one point.
};

/// The sensors of a set of views.
struct Sensors {
  std::vector<std::size_t> of_view;  ///< Index into `models`.
  std::vector<SensorModel> models;
};

/// Views with the same kind of camera, size of grid and intrinsics share a sensor. `spacings`: of
/// the views' samples [unit].
Sensors find_sensors(const std::vector<const RangeView*>& views,
                     const std::vector<double>& spacings);

}  // namespace relief::registration
