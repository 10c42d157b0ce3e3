#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "relief/registration/align_options.h"
#include "relief/registration/align_views.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::registration {

/// What the calibration of a sensor may have wrong. Each is one term or a few of the model (C1);
/// docs/calibration.md has their formulas.
enum class SensorError {
  kRangeOffset,           ///< Ranges are longer by a length.
  kRangeScale,            ///< Ranges are longer by a factor.
  kRangeNonlinearity,     ///< Ranges are longer by a square of their distance from the mean range.
  kQuadraticWarp,         ///< Ranges err by a polynomial of the pixel, of degree 1 and 2.
  kCubicWarp,             ///< The terms of degree 3.
  kQuarticWarp,           ///< The terms of degree 4.
  kFocalLength,           ///< Of pinhole cameras: both focal lengths.
  kAspectRatio,           ///< Of pinhole cameras: one focal length against the other.
  kPrincipalPoint,        ///< Of pinhole cameras.
  kRadialDistortion,      ///< Of pinhole cameras: Brown's k1 and k2.
  kTangentialDistortion,  ///< Of pinhole cameras: Brown's p1 and p2.
  kInterlacing,           ///< Of tables of rays: every other row is shifted along itself.
  kRayLengths,  ///< Of pinhole cameras: distances along the rays are read as depths. A mistake of
                ///< the input, told by alignment and never corrected.
};

/// Which views share the errors of a sensor.
enum class CalibrationScope {
  kOff,      ///< Nothing is estimated.
  kAuto,     ///< Errors that views share, then errors of the ranges of single views.
  kShared,   ///< Errors that the views of a sensor share.
  kPerView,  ///< As kAuto, with those of single views that views left out do not confirm.
};

struct CalibrationOptions {
  CalibrationScope scope = CalibrationScope::kAuto;
  /// Samples of the source, per direction of a pair of views, at most; >= 100. Bounds the time.
  int samples = 6000;
};

/// An error that was estimated, over all sensors and views that have it.
struct CalibratedError {
  SensorError error = SensorError::kRangeOffset;
  bool per_view = false;  ///< Else shared by the views of one sensor.
  /// By how much the error lowers the squared residuals of held-out correspondences, relative to
  /// the sum before it was estimated, and the standard error of that.
  double held_out_gain = 0.0, held_out_gain_std = 0.0;
  /// The same of views that took no part in the estimate (C4).
  double left_out_views_gain = 0.0, left_out_views_gain_std = 0.0;
  /// How far the error moves samples along their normals [unit], root mean square, and the standard
  /// deviation of that.
  double size = 0.0, size_std = 0.0;
};

/// The errors of one view.
struct ViewCalibration {
  std::size_t sensor = 0;  ///< Views of one sensor have the same number.
  /// Of the terms of its sensor (C1), as corrected_view() takes them; empty: there is nothing to
  /// correct.
  std::vector<double> coefficients, coefficient_std;
};

/// What is known of the sensors of a set of views. Lengths in the unit of the views.
struct SensorCalibration {
  std::vector<CalibratedError> errors;  ///< In the order in which they were found.
  std::vector<ViewCalibration> views;   ///< In the order given; empty where nothing was found.
  /// Of the corrected views. Covariances of poses include those of the errors.
  Alignment alignment;
  /// Robust deviation of the point-to-plane distances, median over pairs [unit].
  double deviation_before = 0.0, deviation_after = 0.0;
  int iterations = 0;  ///< Renewals of the correspondences.
  /// In words: what was found, with deviations, and what the views do not determine.
  std::vector<std::string> notes;

  bool found() const { return !errors.empty(); }
};

/// Estimates what the calibration of the sensors has wrong from overlapping views at nearly right
/// poses, together with these poses (C2). Views with the same kind of camera, size of grid and
/// intrinsics share a sensor. An error is estimated where correspondences and views that took no
/// part in its estimate fit better with it than without, by more than chance. `aligned` is the
/// alignment of the views, made with the options `align`; `views` still have the poses that it was
/// given. Where it left views unverified, and where the corrected views fit as well at their given
/// poses, they are aligned again from these. Views at known poses stay there. Nothing is found
/// where fewer than three views overlap, or more than 200, and where shape alone does not hold all
/// views.
///
/// Errors: kBadInput for options out of range; kInterrupted.
Result<SensorCalibration> calibrate_views(const std::vector<RangeView>& views,
                                          const Alignment& aligned, const AlignOptions& align = {},
                                          const CalibrationOptions& options = {},
                                          const Context& context = {});

/// Gives views their corrected ranges, cameras and poses, where anything was found. `views` are
/// those that were calibrated; their poses may be those of apply_alignment() by then.
void apply_calibration(const SensorCalibration& calibration, std::vector<RangeView>& views);

/// `range offset`, `focal length` ...
std::string_view to_string(SensorError error);

}  // namespace relief::registration
