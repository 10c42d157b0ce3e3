#include "registration/calibration/estimation/pose_inflation.h"

#include <algorithm>
#include <cmath>

#include "registration/calibration/estimation/system_layout.h"
#include "registration/calibration/selection/held_out.h"
#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// Poses and parameters: the coefficients of all terms by those of the model.
Eigen::MatrixXd information_of(const QuadraticSum& all, const SystemLayout& layout,
                               const Sensors& sensors, const ErrorModel& model) {
  const auto parameters = static_cast<Eigen::Index>(model.parameters.size());
  Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(all.gradient.size(), layout.poses + parameters);
  selection.topLeftCorner(layout.poses, layout.poses).setIdentity();
  for (Eigen::Index p = 0; p < parameters; ++p)
    for (const Eigen::Index c :
         layout.coefficients_of(model, model.parameters[static_cast<std::size_t>(p)], sensors))
      selection(layout.poses + c, layout.poses + p) = 1.0;
  Eigen::MatrixXd information = selection.transpose() * all.matrix * selection;
  information.diagonal().tail(parameters).array() += model.prior();
  return information;
}

Eigen::VectorXd variances(Eigen::MatrixXd information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  information = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::MatrixXd inverse = solve_symmetric(
      information, Eigen::MatrixXd(Eigen::MatrixXd::Identity(scale.size(), scale.size())));
  return inverse.diagonal().cwiseProduct(scale.cwiseAbs2());
}

}  // namespace

std::vector<RigidTangent> pose_inflation(const std::vector<PairSums>& pairs, const Sensors& sensors,
                                         const ErrorModel& model, const std::vector<bool>& held) {
  const bool per_view = std::any_of(model.choices.begin(), model.choices.end(),
                                    [](const ErrorChoice& choice) { return choice.per_view; });
  const SystemLayout layout(sensors, held, per_view);
  QuadraticSum all(layout.poses + layout.coefficients);
  for (std::size_t f = 0; f < kFolds; ++f) all += sum_of_fold(pairs, f, sensors, layout);
  const Eigen::MatrixXd both = information_of(all, layout, sensors, model);
  const Eigen::VectorXd with = variances(both);
  const Eigen::VectorXd without = variances(both.topLeftCorner(layout.poses, layout.poses));
  std::vector<RigidTangent> inflation(held.size(), RigidTangent::Ones());
  for (std::size_t i = 0; i < held.size(); ++i)
    for (Eigen::Index k = 0; k < 6 && !held[i]; ++k) {
      const double ratio = with[layout.pose[i] + k] / without[layout.pose[i] + k];
      if (std::isfinite(ratio)) inflation[i][k] = std::sqrt(std::max(1.0, ratio));
    }
  return inflation;
}

}  // namespace relief::registration
