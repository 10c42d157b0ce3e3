#include "registration/posegraph/dense/pose_graph_system.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Dense>

namespace relief::registration {

namespace {

Eigen::Index row_of(std::size_t view) { return static_cast<Eigen::Index>(6 * view); }

// What a pose without any constraint is known to: one radian, one radius of the view.
RigidTangent prior_precision(const ViewSurface& surface) {
  RigidTangent deviation = RigidTangent::Ones();
  deviation.tail<3>() *= surface.radius();
  return deviation.cwiseMax(1e-150).array().square().inverse();
}

// A^-1 B. Scaled to a unit diagonal first: radians and units differ by orders of magnitude.
Eigen::MatrixXd solve_scaled(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * a * scale.asDiagonal();
  return scale.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd(scale.asDiagonal() * b));
}

// Turns tangents about the centre into tangents about `point`, both in world axes.
Matrix6d about_point(const Eigen::Vector3d& point_from_centre) {
  Matrix6d change = Matrix6d::Identity();
  const Eigen::Vector3d& d = point_from_centre;
  change.bottomLeftCorner<3, 3>() << 0.0, d.z(), -d.y(), -d.z(), 0.0, d.x(), d.y(), -d.x(), 0.0;
  return change;
}

// (R11): an edge of the block Laplacian.
void add_edge(const Matrix6d& block, const PairInformation& pair, Eigen::MatrixXd& sum) {
  const Eigen::Index s = row_of(pair.source), t = row_of(pair.target);
  sum.block<6, 6>(s, s) += block;
  sum.block<6, 6>(t, t) += block;
  sum.block<6, 6>(s, t) -= block;
  sum.block<6, 6>(t, s) -= block;
}

}  // namespace

PoseGraphSystem::PoseGraphSystem(const std::vector<const ViewSurface*>& surfaces,
                                 const std::vector<PairInformation>& pairs,
                                 const std::vector<bool>& held, const Eigen::Vector3d& centre)
    : surfaces_(surfaces), pairs_(pairs), centre_(centre) {
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    prior_.push_back(prior_precision(*surfaces[i]));
    for (Eigen::Index k = 0; k < 6 && !held[i]; ++k) free_.push_back(row_of(i) + k);
  }
}

Eigen::MatrixXd PoseGraphSystem::information(double factor) const {
  const Eigen::Index size = row_of(surfaces_.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    sum.diagonal().segment<6>(row_of(i)) = prior_[i];
  for (const auto& pair : pairs_)
    add_edge(factor * (pair.information - pair.independent) + pair.independent, pair, sum);
  return sum;
}

Eigen::MatrixXd PoseGraphSystem::scatter(const ClusterScores& scores) const {
  const Eigen::Index size = row_of(surfaces_.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    sum.diagonal().segment<6>(row_of(i)) = prior_[i];
  const auto entries = scores.sorted();
  std::size_t patches = 0;
  for (auto begin = entries.begin(); begin != entries.end(); ++patches) {
    const auto end = std::find_if(begin, entries.end(),
                                  [&](const auto& entry) { return entry.patch != begin->patch; });
    for (auto a = begin; a != end; ++a)
      for (auto b = begin; b != end; ++b)
        sum.block<6, 6>(row_of(a->view), row_of(b->view)) += a->score * b->score.transpose();
    begin = end;
  }
  // The poses were fitted to these scores, which took as many degrees of freedom from them.
  const auto count = static_cast<double>(patches), fitted = static_cast<double>(free_.size());
  sum *= variance_inflation(scores) * std::min(2.0, count / std::max(1.0, count - fitted));
  for (const auto& pair : pairs_) add_edge(pair.independent, pair, sum);
  return sum;
}

// The sum of the squared scores, each relative to what its view's information makes it scatter by.
double PoseGraphSystem::spread(const ClusterScores& scores) const {
  const Eigen::MatrixXd all = information(1.0);
  std::vector<Matrix6d> variance;  // Of a pose, were all other views held.
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    variance.push_back(solve_scaled(all.block<6, 6>(row_of(i), row_of(i)), Matrix6d::Identity()));
  double sum = 0.0;
  for (const auto& entry : scores.sorted())
    sum += entry.score.dot(variance[entry.view] * entry.score);
  return sum;
}

double PoseGraphSystem::variance_inflation(const ClusterScores& scores) const {
  const double apart = spread(scores);
  return apart > 0.0 ? std::max(1.0, spread(scores.on_larger_clusters()) / apart) : 1.0;
}

Eigen::VectorXd PoseGraphSystem::score_of(const std::vector<PairInformation>& pairs) const {
  Eigen::VectorXd score = Eigen::VectorXd::Zero(row_of(surfaces_.size()));
  for (const auto& pair : pairs) {
    score.segment<6>(row_of(pair.source)) += pair.score;
    score.segment<6>(row_of(pair.target)) -= pair.score;
  }
  return score;
}

std::vector<RigidTangent> PoseGraphSystem::step() const {
  std::vector<RigidTangent> steps(surfaces_.size(), RigidTangent::Zero());
  if (free_.empty()) return steps;
  const Eigen::VectorXd moved =
      solve_scaled(information(1.0)(free_, free_), -score_of(pairs_)(free_));
  for (std::size_t k = 0; k < free_.size(); ++k)
    steps[static_cast<std::size_t>(free_[k] / 6)][free_[k] % 6] =
        moved[static_cast<Eigen::Index>(k)];
  return steps;
}

std::vector<RigidTangent> PoseGraphSystem::random_perturbation() const {
  std::vector<RigidTangent> tangents(surfaces_.size(), RigidTangent::Zero());
  const Eigen::VectorXd information_of = information(1.0).diagonal();
  std::uint64_t bits = 0x9e3779b97f4a7c15U;  // A linear congruence scatters them (Knuth 1997).
  for (const Eigen::Index row : free_) {
    bits = bits * 6364136223846793005U + 1442695040888963407U;
    const double sign = (bits >> 63) != 0 ? 1.0 : -1.0;
    const auto view = static_cast<std::size_t>(row / 6);
    // What nothing but the prior holds is not perturbed.
    if (information_of[row] > 2.0 * prior_[view][row % 6])
      tangents[view][row % 6] = sign / std::sqrt(information_of[row]);
  }
  return tangents;
}

double PoseGraphSystem::step_gain(const std::vector<PairInformation>& moved,
                                  const std::vector<RigidTangent>& tangents) const {
  const Eigen::VectorXd change = score_of(moved) - score_of(pairs_);
  double found = 0.0, expected = 0.0;
  for (const auto& pair : pairs_) {
    const RigidTangent relative = tangents[pair.source] - tangents[pair.target];
    expected += relative.dot(pair.information * relative);
  }
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    found += tangents[i].dot(change.segment<6>(row_of(i)));
  // Beyond these the perturbation met something else than noise.
  constexpr double kLeast = 0.4, kMost = 1.0;
  return expected > 0.0 ? std::clamp(found / expected, kLeast, kMost) : kMost;
}

Eigen::MatrixXd PoseGraphSystem::covariance(const std::vector<RigidMotion>& world_from_view,
                                            const ClusterScores& scores, double step_gain) const {
  const Eigen::Index size = row_of(surfaces_.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  if (free_.empty()) return result;
  // (R12): A^-1 B A^-1.
  const Eigen::MatrixXd a = information(step_gain)(free_, free_);
  const Eigen::MatrixXd half = solve_scaled(a, scatter(scores)(free_, free_));
  const Eigen::MatrixXd covariance = solve_scaled(a, half.transpose());
  result(free_, free_) = 0.5 * (covariance + covariance.transpose());
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Matrix6d change = about_point(world_from_view[i] * surfaces_[i]->centre() - centre_);
    const Eigen::Index row = row_of(i);
    result.middleRows<6>(row) = (change * result.middleRows<6>(row)).eval();
    result.middleCols<6>(row) = (result.middleCols<6>(row) * change.transpose()).eval();
  }
  return result;
}

}  // namespace relief::registration
