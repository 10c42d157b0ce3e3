#include "registration/posegraph/loops/pair_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Both directions of a pair by the motion of its first view relative to its second.
struct BothWays {
  Matrix6d information = Matrix6d::Zero(), independent = Matrix6d::Zero();
  RigidTangent score = RigidTangent::Zero();
  std::map<std::uint64_t, RigidTangent> patches;

  void add(const PairInformation& pair, double sign, double step_gain) {
    information += step_gain * (pair.information - pair.independent) + pair.independent;
    independent += pair.independent;
    score += sign * pair.score;
    for (const PatchScore& patch : pair.patches)
      patches.try_emplace(patch.patch, RigidTangent::Zero()).first->second += sign * patch.score;
  }
};

// An orthonormal basis of the motions that the pair determines, rotations in units of 1 / lever.
Eigen::MatrixXd determined_motions(const std::vector<DegenerateDirection>& degenerate,
                                   const Eigen::Vector3d& centre, double lever) {
  const auto count = static_cast<Eigen::Index>(degenerate.size());
  if (count == 0) return Matrix6d::Identity();
  Eigen::MatrixXd fixed(6, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    fixed.col(k) = tangent_about(centre, degenerate[static_cast<std::size_t>(k)]);
    fixed.col(k).head<3>() *= lever;
  }
  // Those that `fixed` spans have eigenvalues above 0.
  return eigen_decomposition(Matrix6d(fixed * fixed.transpose()))
      .eigenvectors()
      .leftCols(6 - std::min<Eigen::Index>(count, 6));
}

// The inverse of the information among the motions that the pair determines; zero for the others.
Matrix6d inverse_among(const Matrix6d& information,
                       const std::vector<DegenerateDirection>& degenerate,
                       const Eigen::Vector3d& centre) {
  // Directions weaker than the strongest by this are rounding, as in quadratic_residuals().
  constexpr double kLeastEigenvalue = 1e-14;
  const Vector6d diagonal = information.diagonal();
  const double translations = diagonal.tail<3>().sum(), rotations = diagonal.head<3>().sum();
  if (!(translations > 0.0) || !(rotations > 0.0)) return Matrix6d::Zero();
  const double lever = std::sqrt(rotations / translations);
  const Eigen::MatrixXd basis = determined_motions(degenerate, centre, lever);
  if (basis.cols() == 0) return Matrix6d::Zero();
  Vector6d unscale = Vector6d::Ones();
  unscale.head<3>().setConstant(1.0 / lever);
  const Eigen::MatrixXd directions = unscale.asDiagonal() * basis;
  const auto eigen =
      eigen_decomposition(Eigen::MatrixXd(directions.transpose() * information * directions));
  Eigen::VectorXd inverse = eigen.eigenvalues();
  const double least = kLeastEigenvalue * inverse[inverse.size() - 1];
  for (double& value : inverse) value = value > least ? 1.0 / value : 0.0;
  const Eigen::MatrixXd found = directions * eigen.eigenvectors();
  return found * inverse.asDiagonal() * found.transpose();
}

}  // namespace

std::vector<PairMotion> motions_of_pairs(const PoseGraphLastStep& last,
                                         const std::vector<PairFit>& fits) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<const PairInformation*>> directions;
  for (const PairInformation& pair : last.pairs)
    if (pair.count > 0) directions[std::minmax(pair.source, pair.target)].push_back(&pair);
  std::map<std::pair<std::size_t, std::size_t>, const PairFit*> fit_of;
  for (const PairFit& fit : fits) fit_of[{fit.a, fit.b}] = &fit;
  std::vector<PairMotion> motions;
  for (const auto& [views, of_views] : directions) {
    check_stop_and_memory();
    BothWays sum;
    for (const PairInformation* pair : of_views)
      sum.add(*pair, pair->source == views.first ? 1.0 : -1.0, last.step_gain);
    const auto fit = fit_of.find(views);
    const Matrix6d inverse = inverse_among(sum.information,
                                           fit == fit_of.end() ? std::vector<DegenerateDirection>()
                                                               : fit->second->degenerate_directions,
                                           last.centre);
    if (!inverse.allFinite() || inverse.isZero(0.0)) continue;
    const RigidTangent step = last.tangents[views.first] - last.tangents[views.second];
    PairMotion own;
    std::tie(own.a, own.b) = views;
    own.motion = -inverse * (sum.score + sum.information * step);
    own.independent = inverse * sum.independent * inverse;
    for (const auto& [patch, score] : sum.patches)
      own.influence.push_back({patch, RigidTangent(-inverse * score)});
    motions.push_back(std::move(own));
  }
  return motions;
}

}  // namespace relief::registration
