#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/model/sensor_model.h"
#include "registration/pairwise/correspondences.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Parts that the correspondences are cut into. Each in turn is held out while the others determine
/// the errors. Five folds are the usual number (Hastie, Tibshirani and Friedman 2009,
/// section 7.10).
inline constexpr std::size_t kFolds = 5;

/// Sums of a weighted least-squares problem: of w j j^T, and of w r j.
struct QuadraticSum {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd gradient;
  double squares = 0.0;  ///< Sum of w r^2.

  explicit QuadraticSum(Eigen::Index size = 0)
      : matrix(Eigen::MatrixXd::Zero(size, size)), gradient(Eigen::VectorXd::Zero(size)) {}

  QuadraticSum& operator+=(const QuadraticSum& other);
};

/// The views that are calibrated, at their present poses.
struct CalibratedViews {
  const std::vector<RangeView>* given = nullptr;       ///< As measured: (C1) takes their cameras.
  const std::vector<ViewSurface>* surfaces = nullptr;  ///< As corrected so far.
  const Sensors* sensors = nullptr;
  std::vector<Grid<double>> nearby_ranges;  ///< Of the corrected views: see nearby_ranges().
  std::vector<RigidMotion> world_from_view;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of the tangents; world frame.

  const SensorModel& sensor_of(std::size_t view) const {
    return sensors->models[sensors->of_view[view]];
  }
};

/// What the correspondences of a directed pair say, by fold: of the motion of the source relative
/// to the target, a tangent about the centre (6 components), the terms of the source's sensor, and
/// those of the target's.
struct PairSums {
  std::size_t source = 0, target = 0;
  double deviation = 0.0;  ///< Robust, of the residuals [unit]; 0: the views share nothing.
  std::array<QuadraticSum, kFolds> folds;
};

/// The range near each pixel: the mean of opposite samples some pixels away, NaN where there are
/// none. It shares no noise with the sample of the pixel. With the sample's own range in (C1), all
/// errors that contract the views would seem to fit: they lessen the noise.
Grid<double> nearby_ranges(const RangeView& view);

/// What the errors of both views of a directed pair together move the surface by: the mean squared
/// motion along the normals of all correspondences, weighted as in the sums, by the terms of the
/// source and then of the target. The errors that views have apart average out where they overlap.
Eigen::MatrixXd common_motion(const PairSums& pair, Eigen::Index source_terms);

struct CalibrationSumOptions {
  CorrespondenceOptions search;
  std::size_t samples = 6000;  ///< Of the source, per directed pair.
  double patch = 0.0;          ///< Edge of the cubes that are in one fold as a whole [unit].
};

/// The sums of both directions of all pairs. Equation (C2), linearised where the views are.
std::vector<PairSums> sum_pairs(const CalibratedViews& views, const std::vector<ViewPair>& pairs,
                                const CalibrationSumOptions& options);
/// Calls `take` with the sums of sum_pairs(), in their order. Few of them are in memory at a time.
void for_each_pair_sums(const CalibratedViews& views, const std::vector<ViewPair>& pairs,
                        const CalibrationSumOptions& options,
                        const std::function<void(PairSums)>& take);

}  // namespace relief::registration
