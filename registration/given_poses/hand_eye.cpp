#include "registration/given_poses/hand_eye.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <Eigen/Dense>

#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

constexpr std::size_t kFewestViews = 3;  // Two motions: twelve equations for seven unknowns.
// Errors of so small a part of those of the given poses are rounding.
constexpr double kRounding = 1e-6;
// A simpler correction is taken if it leaves no more than this many times what the best one does.
constexpr double kAlmostAsGood = 2.0;
// Each view makes motions with so many that follow it. Bounds the time.
constexpr std::size_t kMostPartners = 40;
// Half turns, whose axes have no sense, tell no rotation [rad].
constexpr double kNearlyHalfTurn = 3.0;
// Motions that fit worse than this many times the median are left out of the second fit.
constexpr double kOutlier = 3.0;
// Directions in which equations say less than this part of what they say of others.
constexpr double kUndetermined = 1e-3;

// The motions of two views to each other.
struct Motion {
  RigidMotion given, found;
  Eigen::Vector3d centre;  // Of the samples of the second view, in its frame.
};

std::vector<Motion> motions_of(const std::vector<GivenAndFound>& views) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(views.size(), i + 1 + kMostPartners); ++j)
      motions.push_back({views[i].given.inverse() * views[j].given,
                         views[i].found.inverse() * views[j].found, views[j].centre});
  return motions;
}

Eigen::Vector3d rotation_vector(const RigidMotion& motion) {
  const Eigen::AngleAxisd rotation(motion.linear());
  return rotation.angle() * rotation.axis();
}

// By how much the samples of the second view are off in the frame of the first [unit].
double error_of(const HandEye& hand_eye, const Motion& motion) {
  RigidMotion given = motion.given;
  given.translation() *= hand_eye.scale;
  const RigidMotion& x = hand_eye.body_from_view;
  const RigidMotion expected = x.inverse() * given * x;
  const double turn = rotation_angle(expected.inverse() * motion.found);
  return (expected * motion.centre - motion.found * motion.centre).norm() +
         turn * motion.centre.norm();
}

std::vector<double> errors_of(const HandEye& hand_eye, const std::vector<Motion>& motions) {
  std::vector<double> errors;
  for (const Motion& motion : motions) errors.push_back(error_of(hand_eye, motion));
  return errors;
}

double median_error(const HandEye& hand_eye, const std::vector<Motion>& motions) {
  return quantile(errors_of(hand_eye, motions), 0.5);
}

// Rotation vectors turn with the axes of the frame that they are in.
Eigen::Matrix3d rotation_of_body(const std::vector<Motion>& motions) {
  std::vector<Eigen::Vector3d> given, found;
  for (const Motion& motion : motions) {
    if (rotation_angle(motion.given) > kNearlyHalfTurn) continue;
    for (const double sign : {1.0, -1.0}) {  // So that the mean is zero.
      given.emplace_back(sign * rotation_vector(motion.given));
      found.emplace_back(sign * rotation_vector(motion.found));
    }
  }
  Eigen::Matrix3Xd source(3, found.size()), target(3, given.size());
  for (std::size_t k = 0; k < given.size(); ++k) {
    source.col(static_cast<Eigen::Index>(k)) = found[k];
    target.col(static_cast<Eigen::Index>(k)) = given[k];
  }
  if (given.empty()) return Eigen::Matrix3d::Identity();
  return best_rigid_motion(source, target).linear();
}

// Which unknowns a fit has.
struct Unknowns {
  bool body = false, scale = false;
};

// (R - I) x + (s - 1) t = R_x t_found - t with R and t of the given motion. Along and about the one
// axis of a turntable the world moves with the sensor: nothing changes.
HandEye fit(const std::vector<Motion>& motions, const Unknowns& unknowns) {
  HandEye fitted;
  if (unknowns.body) fitted.body_from_view.linear() = rotation_of_body(motions);
  const auto rows = static_cast<Eigen::Index>(3 * motions.size());
  Eigen::MatrixXd matrix(rows, (unknowns.body ? 3 : 0) + (unknowns.scale ? 1 : 0));
  Eigen::VectorXd right(rows);
  double farthest = 0.0;
  for (const Motion& motion : motions)
    farthest = std::max(farthest, motion.given.translation().norm());
  if (!(farthest > 0.0)) farthest = 1.0;
  for (std::size_t k = 0; k < motions.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(3 * k);
    const RigidMotion& given = motions[k].given;
    if (unknowns.body) matrix.block<3, 3>(row, 0) = given.linear() - Eigen::Matrix3d::Identity();
    if (unknowns.scale) matrix.block<3, 1>(row, matrix.cols() - 1) = given.translation() / farthest;
    right.segment<3>(row) =
        fitted.body_from_view.linear() * motions[k].found.translation() - given.translation();
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(kUndetermined);
  decomposition.compute(matrix);
  const Eigen::VectorXd solution = decomposition.solve(right);
  if (unknowns.body) fitted.body_from_view.translation() = solution.head<3>();
  if (unknowns.scale) fitted.scale = 1.0 + solution(solution.size() - 1) / farthest;
  return fitted;
}

HandEye robust_fit(const std::vector<Motion>& motions, const Unknowns& unknowns) {
  const HandEye first = fit(motions, unknowns);
  const std::vector<double> errors = errors_of(first, motions);
  const double most = kOutlier * quantile(errors, 0.5);
  std::vector<Motion> kept;
  for (std::size_t k = 0; k < motions.size(); ++k)
    if (errors[k] <= most) kept.push_back(motions[k]);
  return fit(kept, unknowns);
}

}  // namespace

std::optional<HandEye> calibrate_hand_eye(const std::vector<GivenAndFound>& views) {
  if (views.size() < kFewestViews) return std::nullopt;
  const std::vector<Motion> motions = motions_of(views);
  std::vector<std::pair<HandEye, double>> fits;
  for (const Unknowns unknowns :
       {Unknowns{.scale = true}, Unknowns{.body = true}, Unknowns{.body = true, .scale = true}}) {
    const HandEye fitted = robust_fit(motions, unknowns);
    if (fitted.scale > 0.0) fits.emplace_back(fitted, median_error(fitted, motions));
  }
  const double as_given = median_error({}, motions);
  double least = as_given;
  for (const auto& [fitted, error] : fits) least = std::min(least, error);
  if (!(kTellingRatio * least < as_given)) return std::nullopt;
  const double enough = std::max(kAlmostAsGood * least, kRounding * as_given);
  for (const auto& [fitted, error] : fits)
    if (error <= enough) return fitted;
  return std::nullopt;
}

double median_error(const HandEye& hand_eye, const std::vector<GivenAndFound>& views) {
  return median_error(hand_eye, motions_of(views));
}

}  // namespace relief::registration
