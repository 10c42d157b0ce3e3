#include "registration/posegraph/refinement/pose_graph_system.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include <Eigen/Dense>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// Up to so many views all blocks of the inverse come from a QR factorisation, which withstands
// motions that the prior alone holds, in less than a second. Their number grows as the square.
constexpr std::size_t kFewViews = 32;

// What a pose without any constraint is known to: one radian, one radius of the view.
RigidTangent prior_precision(const ViewSurface& surface) {
  RigidTangent deviation = RigidTangent::Ones();
  deviation.tail<3>() *= surface.radius();
  return deviation.cwiseMax(1e-150).array().square().inverse();
}

// The inverse. Scaled to a unit diagonal first: radians and units differ by orders of magnitude.
Matrix6d inverse_of(const Matrix6d& a) {
  const Vector6d scale = a.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = scale.asDiagonal() * a * scale.asDiagonal();
  return scale.asDiagonal() * solve_symmetric(scaled, Matrix6d(scale.asDiagonal()));
}

std::vector<RigidTangent> scores_of_views(const std::vector<PairInformation>& pairs,
                                          std::size_t views) {
  std::vector<RigidTangent> scores(views, RigidTangent::Zero());
  for (const auto& pair : pairs) {
    scores[pair.source] += pair.score;
    scores[pair.target] -= pair.score;
  }
  return scores;
}

void add_block(std::size_t row, std::size_t column, const Matrix6d& block, SymmetricBlocks& sum) {
  sum.try_emplace({row, column}, Matrix6d::Zero()).first->second += block;
}

// (R11): an edge of the block Laplacian.
void add_edge(const PairInformation& pair, const Matrix6d& block, SymmetricBlocks& sum) {
  const auto [first, second] = std::minmax(pair.source, pair.target);
  add_block(first, first, block, sum);
  add_block(second, second, block, sum);
  add_block(first, second, -block, sum);
}

}  // namespace

PoseGraphSystem::PoseGraphSystem(const std::vector<const ViewSurface*>& surfaces,
                                 const std::vector<PairInformation>& pairs,
                                 const std::vector<bool>& held, const Eigen::Vector3d& centre,
                                 std::vector<Matrix6d> projection)
    : surfaces_(surfaces), pairs_(pairs), held_(held), centre_(centre) {
  for (const ViewSurface* surface : surfaces) allowed_.prior.push_back(prior_precision(*surface));
  allowed_.projection = std::move(projection);
  allowed_.projection.resize(surfaces.size(), Matrix6d::Identity());
}

// The diagonal blocks of (R11), with the priors.
std::vector<Matrix6d> PoseGraphSystem::information_of_views() const {
  std::vector<Matrix6d> blocks;
  for (const RigidTangent& prior : allowed_.prior) blocks.push_back(prior.asDiagonal());
  for (const auto& pair : pairs_) {
    blocks[pair.source] += pair.information;
    blocks[pair.target] += pair.information;
  }
  return blocks;
}

// B of (R12). Few views see a patch, so few blocks are not zero.
SymmetricBlocks PoseGraphSystem::scatter(const ClusterScores& scores, double inflation) const {
  SymmetricBlocks sum;
  std::size_t patches = 0;
  scores.for_each_cluster([&](std::uint64_t, std::span<const ClusterScores::Entry> entries) {
    ++patches;
    for (auto a = entries.begin(); a != entries.end(); ++a)
      for (auto b = a; b != entries.end(); ++b)
        add_block(a->view, b->view, a->score * b->score.transpose(), sum);
  });
  // The poses were fitted to these scores, which took as many degrees of freedom from them.
  const auto count = static_cast<double>(patches);
  const auto fitted = 6.0 * static_cast<double>(std::count(held_.begin(), held_.end(), false));
  const double factor = inflation * std::min(2.0, count / std::max(1.0, count - fitted));
  for (auto& [place, block] : sum) block *= factor;
  for (const auto& pair : pairs_)
    if (!pair.independent.isZero(0.0)) add_edge(pair, pair.independent, sum);
  for (auto& [place, block] : sum)
    block =
        allowed_.projection[place.first].transpose() * block * allowed_.projection[place.second];
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    add_block(i, i, allowed_.prior[i].asDiagonal(), sum);
  return sum;
}

// The sum of the squared scores, each relative to what its view's information makes it scatter by.
double PoseGraphSystem::spread(const ClusterScores& scores) const {
  std::vector<Matrix6d> variance;  // Of a pose, were all other views held.
  for (const Matrix6d& information : information_of_views())
    variance.push_back(inverse_of(information));
  double sum = 0.0;
  scores.for_each_cluster([&](std::uint64_t, std::span<const ClusterScores::Entry> entries) {
    for (const auto& entry : entries) sum += entry.score.dot(variance[entry.view] * entry.score);
  });
  return sum;
}

double PoseGraphSystem::variance_inflation(const ClusterScores& scores) const {
  const double apart = spread(scores);
  return apart > 0.0 ? std::max(1.0, spread(scores.on_larger_clusters()) / apart) : 1.0;
}

PoseGraphStep PoseGraphSystem::step() const {
  return PoseGraphProblem(pairs_, allowed_, held_).minimise();
}

std::vector<RigidTangent> PoseGraphSystem::random_perturbation() const {
  std::vector<RigidTangent> tangents(surfaces_.size(), RigidTangent::Zero());
  const auto information = information_of_views();
  std::uint64_t bits = 0x9e3779b97f4a7c15U;  // A linear congruence scatters them (Knuth 1997).
  for (std::size_t view = 0; view < tangents.size(); ++view) {
    for (Eigen::Index k = 0; k < 6 && !held_[view]; ++k) {
      bits = bits * 6364136223846793005U + 1442695040888963407U;
      const double sign = (bits >> 63) != 0 ? 1.0 : -1.0;
      const double precision = information[view](k, k);
      // What nothing but the prior holds is not perturbed.
      if (precision > 2.0 * allowed_.prior[view][k])
        tangents[view][k] = sign / std::sqrt(precision);
    }
    tangents[view] = allowed_.projection[view] * tangents[view];
  }
  return tangents;
}

double PoseGraphSystem::step_gain(const std::vector<PairInformation>& moved,
                                  const std::vector<RigidTangent>& tangents) const {
  const auto before = scores_of_views(pairs_, tangents.size());
  const auto after = scores_of_views(moved, tangents.size());
  double found = 0.0, expected = 0.0;
  for (const auto& pair : pairs_) {
    const RigidTangent relative = tangents[pair.source] - tangents[pair.target];
    expected += relative.dot(pair.information * relative);
  }
  for (std::size_t i = 0; i < tangents.size(); ++i) found += tangents[i].dot(after[i] - before[i]);
  // Beyond these the perturbation met something else than noise: Gaussian residuals give 0.79, the
  // mean second derivative of the Cauchy loss over its mean weight, and 0.4 is half of that.
  constexpr double kLeast = 0.4, kMost = 1.0;
  return expected > 0.0 ? std::clamp(found / expected, kLeast, kMost) : kMost;
}

std::optional<PoseCovariance> PoseGraphSystem::covariance(
    const std::vector<RigidMotion>& world_from_view, const ClusterScores& scores, double inflation,
    double step_gain) const {
  std::vector<Eigen::Vector3d> centres;
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    centres.push_back(world_from_view[i] * surfaces_[i]->centre() - centre_);
  SymmetricBlocks middle = scatter(scores, inflation);
  if (surfaces_.size() > kFewViews) {
    auto of_views =
        sandwich_diagonal(information_blocks(pairs_, allowed_, step_gain), middle, held_);
    if (of_views) return PoseCovariance(std::move(*of_views), std::move(centres));
  }
  PoseGraphProblem information(pairs_, allowed_, held_, step_gain);
  if (!information.invert()) return std::nullopt;
  return PoseCovariance(std::move(information), std::move(middle), std::move(centres));
}

}  // namespace relief::registration
