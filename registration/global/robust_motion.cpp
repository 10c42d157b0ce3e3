#include "registration/global/robust_motion.h"

#include <cassert>
#include <cmath>

namespace relief::registration {

namespace {

// Per step: 1.4 (Yang et al. 2020) finds the same in 1.4 times the steps, log 1.6 / log 1.4.
constexpr double kSharpening = 1.6;
constexpr int kMostSteps = 60;  // They sharpen by 1e12: enough to decide all weights.

// The weight of a residual while the loss is still rounded by `mu` (Yang et al. 2020, equation 14).
double rounded_weight(double squared, double squared_tolerance, double mu) {
  if (squared <= mu / (mu + 1.0) * squared_tolerance) return 1.0;
  if (squared >= (mu + 1.0) / mu * squared_tolerance) return 0.0;
  return std::sqrt(squared_tolerance * mu * (mu + 1.0) / squared) - mu;
}

}  // namespace

RobustMotion fit_robustly(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target,
                          double tolerance) {
  assert(source.cols() == target.cols() && tolerance > 0.0);
  RobustMotion result;
  if (source.cols() < 3) return result;
  const double squared_tolerance = tolerance * tolerance;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(source.cols()), squared;
  const auto fit = [&] {
    result.target_from_source = best_rigid_motion(source, target, weights);
    squared = (target - result.target_from_source * source).colwise().squaredNorm();
  };
  fit();
  // From a loss that is convex over all residuals to one that is truncated at the tolerance.
  double mu = squared_tolerance /
              std::max(2.0 * squared.maxCoeff() - squared_tolerance, 1e-6 * squared_tolerance);
  for (int step = 0; step < kMostSteps && squared.maxCoeff() > squared_tolerance; ++step) {
    const Eigen::VectorXd before = weights;
    for (Eigen::Index i = 0; i < weights.size(); ++i)
      weights[i] = rounded_weight(squared[i], squared_tolerance, mu);
    if (weights.sum() < 1e-9) return {};
    fit();
    const bool decided = ((weights.array() < 1e-6) || (weights.array() > 1.0 - 1e-6)).all();
    if (decided && weights == before) break;
    mu *= kSharpening;
  }
  for (Eigen::Index i = 0; i < squared.size(); ++i)
    if (squared[i] <= squared_tolerance) result.inliers.push_back(static_cast<std::size_t>(i));
  return result;
}

}  // namespace relief::registration
