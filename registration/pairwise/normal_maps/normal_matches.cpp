#include "registration/pairwise/normal_maps/normal_matches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Dense>

#include "registration/pairwise/robust.h"
#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// [rad]; exact maps have none. Half of what the rounding of 8 bits leaves, 2 / 255 / sqrt(12).
constexpr double kLeastSigma = 1e-3;
constexpr double kMaxSigmas = 4.0;  // Standard deviations; 6e-5 of a Gaussian lies beyond.
// Standard deviations by which the agreement of gradients must exceed chance: 3e-7 of a Gaussian
// does.
constexpr double kSignificant = 5.0;
// Derivatives correlate by 1 / (1 + n) under noise of n times their variance: 0.3 allows 2.3.
constexpr double kLeastCorrelation = 0.3;

// Squares of slopes: four times the slope. Far larger takes maps everywhere, which is worse on the
// bear (docs/results.md, Normal maps); 1 leaves slopes just above the threshold to noise.
constexpr double kNearlySliding = 16.0;
// [pixels]. Smaller misses what neighbours share farther; larger leaves few sums, 25 of 160 x 160.
constexpr int kPatch = 32;
// Cells that enter one value and its derivatives to equal parts: interpolation is bilinear.
constexpr double kCellsOfAMatch = 4.0;

using Gradient = Eigen::Matrix<double, 3, 2>;

std::optional<NormalMatch> match_at(const ViewSurface& source, const ViewSurface& target,
                                    const Eigen::Matrix3d& rotation, const Correspondence& c,
                                    int level) {
  const auto of_source = source.signal(c.source, level);
  if (!of_source) return std::nullopt;
  const auto of_target = target.signal(c.target, level);
  if (!of_target) return std::nullopt;
  NormalMatch match;
  match.point = c.target.point;
  match.normal = rotation * of_source->normal;
  match.basis.col(0) = of_target->normal.unitOrthogonal();
  match.basis.col(1) = of_target->normal.cross(match.basis.col(0));
  match.source_gradient =
      (match.basis.transpose() * rotation * of_source->gradient * rotation.transpose()).transpose();
  match.target_gradient = (match.basis.transpose() * of_target->gradient).transpose();
  match.residual = match.basis.transpose() * match.normal;
  match.weight = c.weight;
  return match;
}

double deviation(const std::vector<NormalMatch>& items) {
  std::vector<double> residuals;
  residuals.reserve(2 * items.size());
  for (const auto& match : items)
    for (int k = 0; k < 2; ++k) residuals.push_back(match.residual[k]);
  return std::max(robust_sigma(std::move(residuals)), kLeastSigma);
}

// By how much the mean of residuals varies more than if they were independent, found from the sums
// over patches of the target's map: what neighbours have in common is no relief, or already known.
double shared_variance(const std::vector<NormalMatch>& items, const Correspondences& matched) {
  std::map<std::pair<int, int>, Eigen::Vector3d> sums;
  double squares = 0.0;
  for (const NormalMatch& match : items) {
    const Eigen::Vector2d& pixel = matched.items[match.correspondence].target.pixel;
    const Eigen::Vector3d difference = match.basis * match.residual;
    const std::pair patch(static_cast<int>(pixel.x()) / kPatch,
                          static_cast<int>(pixel.y()) / kPatch);
    sums.try_emplace(patch, Eigen::Vector3d::Zero()).first->second += difference;
    squares += difference.squaredNorm();
  }
  double shared = 0.0;
  for (const auto& [patch, sum] : sums) shared += sum.squaredNorm();
  return squares > 0.0 ? std::max(1.0, shared / squares) : 1.0;
}

// The derivatives of one residual that either view gives, in the basis of a ConstraintSpectrum and
// its unit.
struct RowPair {
  Vector6d by_source, by_target;
};

std::vector<RowPair> row_pairs(const ConstraintSpectrum& spectrum, const NormalMatches& matches,
                               double length_per_angle) {
  Vector6d scale = Vector6d::Constant(length_per_angle);  // By (turn, shift / radius), in radii.
  scale.head<3>() /= spectrum.radius;
  const Matrix6d to_basis = spectrum.directions.transpose() * scale.asDiagonal();
  std::vector<RowPair> rows;
  rows.reserve(2 * matches.items.size());
  for (const auto& match : matches.items)
    for (int k = 0; k < 2; ++k)
      rows.push_back({to_basis * match.derivative(k, match.source_gradient, spectrum.centre),
                      to_basis * match.derivative(k, match.target_gradient, spectrum.centre)});
  return rows;
}

// The directions of the leading `free` ones along which the two views agree most and least.
Eigen::MatrixXd principal_agreement(const std::vector<RowPair>& rows, Eigen::Index free) {
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(free, free);
  for (const auto& [s, t] : rows) common += s.head(free) * t.head(free).transpose();
  return eigen_decomposition(Eigen::MatrixXd(common + common.transpose())).eigenvectors();
}

// The sum of products of both derivatives along `direction`; 0 where chance may explain it or the
// two agree in little: at a wrong place, one relief looks like another now and then.
double significant_agreement(const std::vector<RowPair>& rows, double redundancy,
                             const Eigen::VectorXd& direction) {
  double products = 0.0, squares = 0.0, by_source = 0.0, by_target = 0.0;
  for (const auto& row : rows) {
    const double s = direction.dot(row.by_source.head(direction.size()));
    const double t = direction.dot(row.by_target.head(direction.size()));
    products += s * t;
    squares += s * t * s * t;
    by_source += s * s;
    by_target += t * t;
  }
  const bool significant = products > kSignificant * std::sqrt(redundancy * squares) &&
                           products > kLeastCorrelation * std::sqrt(by_source * by_target);
  return significant ? products : 0.0;
}

}  // namespace

Vector6d NormalMatch::derivative(int k, const Gradient& gradient,
                                 const Eigen::Vector3d& centre) const {
  Vector6d j;
  j << normal.cross(basis.col(k)) - (point - centre).cross(gradient.col(k)), -gradient.col(k);
  return j;
}

NormalMatch NormalMatch::moved(const RigidMotion& motion) const {
  NormalMatch other = *this;
  other.point = motion * point;
  other.normal = motion.linear() * normal;
  other.basis = motion.linear() * basis;
  other.source_gradient = motion.linear() * source_gradient;
  other.target_gradient = motion.linear() * target_gradient;
  return other;
}

NormalMatch NormalMatch::reversed() const {
  NormalMatch other = *this;
  other.residual = -residual;
  return other;
}

NormalMatches match_normals(const ViewSurface& source, const ViewSurface& target,
                            const RigidMotion& target_from_source,
                            const Correspondences& correspondences, int level) {
  NormalMatches matches;
  if (level >= source.signal_levels() || level >= target.signal_levels()) return matches;
  const Eigen::Matrix3d rotation = target_from_source.linear();
  for (std::size_t i = 0; i < correspondences.items.size(); ++i) {
    auto match = match_at(source, target, rotation, correspondences.items[i], level);
    if (!match) continue;
    match->correspondence = i;
    matches.items.push_back(*match);
  }
  matches.sigma = deviation(matches.items);
  const double limit = kMaxSigmas * matches.sigma;
  std::erase_if(matches.items, [&](const NormalMatch& match) {
    return match.residual.cwiseAbs().maxCoeff() > limit;
  });
  const double density = static_cast<double>(matches.items.size()) /
                         (correspondences.overlap() * static_cast<double>(source.samples().size()));
  matches.redundancy = std::max(1.0, kCellsOfAMatch * std::ldexp(density, 2 * level));
  matches.effective_sigma =
      matches.sigma * std::sqrt(shared_variance(matches.items, correspondences));
  return matches;
}

ConstraintSpectrum with_normal_maps(const ConstraintSpectrum& geometric,
                                    const NormalMatches& matches, double length_per_angle,
                                    double threshold) {
  const auto free = static_cast<Eigen::Index>((geometric.eigenvalues.array() < threshold).count());
  if (free == 0 || matches.items.empty()) return geometric;
  const auto rows = row_pairs(geometric, matches, length_per_angle);
  const Eigen::MatrixXd turned = principal_agreement(rows, free);
  ConstraintSpectrum result = geometric;
  result.directions.leftCols(free) = geometric.directions.leftCols(free) * turned;
  for (Eigen::Index i = 0; i < free; ++i) {
    const Eigen::VectorXd direction = turned.col(i);
    result.eigenvalues[i] = direction.cwiseAbs2().dot(geometric.eigenvalues.head(free));
    const double agreement = significant_agreement(rows, matches.redundancy, direction);
    // What agrees beyond chance holds, however little of it there is.
    if (agreement > 0.0)
      result.eigenvalues[i] +=
          std::max(threshold, agreement / static_cast<double>(matches.items.size()));
  }
  return sorted(result);
}

bool is_nearly_degenerate(const ConstraintSpectrum& geometric, double threshold) {
  return geometric.eigenvalues[0] < kNearlySliding * threshold;
}

void ignore_motion(const RigidTangent& motion, const Eigen::Vector3d& centre,
                   NormalMatches& matches) {
  for (NormalMatch& match : matches.items) {
    const Eigen::Vector3d shift = motion.head<3>().cross(match.point - centre) + motion.tail<3>();
    const double square = shift.squaredNorm();
    if (!(square > 0.0)) continue;
    for (auto* gradient : {&match.source_gradient, &match.target_gradient})
      for (int k = 0; k < 2; ++k)
        gradient->col(k) += match.derivative(k, *gradient, centre).dot(motion) / square * shift;
  }
}

}  // namespace relief::registration
