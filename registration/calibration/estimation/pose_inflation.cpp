#include "registration/calibration/estimation/pose_inflation.h"

#include <algorithm>
#include <cmath>

#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"
#include "registration/calibration/estimation/system_sum.h"
#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// Of each component, what the parameters of a model add: those of the poses where the parameters
// are known are `slope` times these.
Eigen::VectorXd variances_by_parameters(const Eigen::MatrixXd& slope,
                                        const Eigen::MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = slope * scale.asDiagonal();
  const Eigen::MatrixXd covariance_times =
      solve_symmetric(Eigen::MatrixXd(scale.asDiagonal() * information * scale.asDiagonal()),
                      Eigen::MatrixXd(scaled.transpose()));
  return scaled.cwiseProduct(covariance_times.transpose()).rowwise().sum();
}

}  // namespace

std::vector<RigidTangent> pose_inflation(const std::vector<PairSums>& pairs, const Sensors& sensors,
                                         const ErrorModel& model, const std::vector<bool>& held) {
  const bool per_view = std::any_of(model.choices.begin(), model.choices.end(),
                                    [](const ErrorChoice& choice) { return choice.per_view; });
  const SystemLayout layout(sensors, held, per_view);
  SystemSum all(layout);
  for (const PairSums& pair : pairs)
    for (std::size_t f = 0; f < kFolds; ++f) all.add(pair, f, sensors, layout);
  const auto coefficients = layout.coefficients_of(model, sensors);
  const EliminatedPoses poses(all, layout);
  Eigen::MatrixXd information = poses.reduce(all, layout).by_parameters(coefficients).matrix;
  information.diagonal().array() += model.prior();
  const Eigen::VectorXd without = variances_of_poses(all, layout);
  const Eigen::VectorXd added =
      variances_by_parameters(columns_by_parameters(poses.slope(), coefficients), information);
  std::vector<RigidTangent> inflation(held.size(), RigidTangent::Ones());
  for (std::size_t i = 0; i < held.size(); ++i)
    for (Eigen::Index k = 0; k < 6 && !held[i]; ++k) {
      const Eigen::Index component = layout.pose[i] + k;
      const double growth = added[component] / without[component];
      if (std::isfinite(growth)) inflation[i][k] = std::sqrt(1.0 + std::max(0.0, growth));
    }
  return inflation;
}

}  // namespace relief::registration
