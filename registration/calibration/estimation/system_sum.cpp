#include "registration/calibration/estimation/system_sum.h"

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace relief::registration {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Factors = Eigen::SimplicialLDLT<SparseMatrix>;

// What keeps poses finite that nothing determines, relative to the precision of a component: far
// above rounding (2e-16) and below all evidence.
constexpr double kRelativePrior = 1e-12;

// Unknowns of a pair and their place among all.
struct Part {
  Eigen::Index from, to, count;
};

std::array<Part, 2> coefficients_of(const PairSums& pair, const Sensors& sensors,
                                    const SystemLayout& layout) {
  const auto terms_of = [&](std::size_t view) {
    return static_cast<Eigen::Index>(sensors.models[sensors.of_view[view]].terms());
  };
  const Eigen::Index source = terms_of(pair.source), target = terms_of(pair.target);
  return {
      {{6, layout.terms[pair.source], source}, {6 + source, layout.terms[pair.target], target}}};
}

// The lower half, with the prior.
SparseMatrix matrix_of(const SymmetricBlocks& poses, const SystemLayout& layout) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * poses.size());
  for (const auto& [place, block] : poses) {
    const Eigen::Index row = layout.pose[place.second], column = layout.pose[place.first];
    for (int c = 0; c < 6; ++c) {
      for (int r = row == column ? c : 0; r < 6; ++r) {
        double value = block(c, r);
        if (row == column && r == c) value += kRelativePrior * value + 1e-300;
        entries.emplace_back(static_cast<int>(row) + r, static_cast<int>(column) + c, value);
      }
    }
  }
  SparseMatrix matrix(layout.poses, layout.poses);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// blocks * columns.
Eigen::MatrixXd product(const SymmetricBlocks& blocks, const Eigen::MatrixXd& columns,
                        const SystemLayout& layout) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(columns.rows(), columns.cols());
  for (const auto& [place, block] : blocks) {
    const Eigen::Index first = layout.pose[place.first], second = layout.pose[place.second];
    result.middleRows<6>(first).noalias() += block * columns.middleRows<6>(second);
    if (first != second)
      result.middleRows<6>(second).noalias() += block.transpose() * columns.middleRows<6>(first);
  }
  return result;
}

}  // namespace

SystemSum::SystemSum(const SystemLayout& layout)
    : cross(Eigen::MatrixXd::Zero(layout.poses, layout.coefficients)),
      coefficients(Eigen::MatrixXd::Zero(layout.coefficients, layout.coefficients)),
      pose_gradient(Eigen::VectorXd::Zero(layout.poses)),
      coefficient_gradient(Eigen::VectorXd::Zero(layout.coefficients)) {
  for (std::size_t view = 0; view < layout.pose.size(); ++view)
    if (layout.pose[view] >= 0) poses.emplace(std::pair(view, view), Matrix6d::Zero());
}

// The motion of a pair is that of its source less that of its target.
void SystemSum::add(const PairSums& pair, std::size_t fold, const Sensors& sensors,
                    const SystemLayout& layout) {
  const QuadraticSum& sum = pair.folds[fold];
  const Matrix6d of_motion = sum.matrix.topLeftCorner<6, 6>();
  const auto parts = coefficients_of(pair, sensors, layout);
  for (const auto& [view, sign] : {std::pair(pair.source, 1.0), std::pair(pair.target, -1.0)}) {
    const Eigen::Index pose = layout.pose[view];
    if (pose < 0) continue;
    poses.at({view, view}) += of_motion;
    pose_gradient.segment<6>(pose) += sign * sum.gradient.head<6>();
    for (const Part& part : parts)
      cross.block(pose, part.to, 6, part.count) +=
          sign * sum.matrix.block(0, part.from, 6, part.count);
  }
  if (layout.pose[pair.source] >= 0 && layout.pose[pair.target] >= 0)
    poses.try_emplace(std::minmax(pair.source, pair.target), Matrix6d::Zero()).first->second -=
        of_motion;
  for (const Part& a : parts) {
    coefficient_gradient.segment(a.to, a.count) += sum.gradient.segment(a.from, a.count);
    for (const Part& b : parts)
      coefficients.block(a.to, b.to, a.count, b.count) +=
          sum.matrix.block(a.from, b.from, a.count, b.count);
  }
  squares += sum.squares;
}

SystemSum& SystemSum::operator+=(const SystemSum& other) {
  for (const auto& [place, block] : other.poses)
    poses.try_emplace(place, Matrix6d::Zero()).first->second += block;
  cross += other.cross;
  coefficients += other.coefficients;
  pose_gradient += other.pose_gradient;
  coefficient_gradient += other.coefficient_gradient;
  squares += other.squares;
  return *this;
}

EliminatedPoses::EliminatedPoses(const SystemSum& sum, const SystemLayout& layout) {
  offset_ = Eigen::VectorXd::Zero(layout.poses);
  slope_ = Eigen::MatrixXd::Zero(layout.poses, layout.coefficients);
  if (layout.poses == 0) return;
  const Factors factors(matrix_of(sum.poses, layout));
  if (factors.info() != Eigen::Success) return;
  offset_ = -factors.solve(sum.pose_gradient);
  slope_ = -factors.solve(sum.cross);
}

ReducedSum EliminatedPoses::reduce(const SystemSum& sum, const SystemLayout& layout) const {
  const Eigen::MatrixXd half = product(sum.poses, slope_, layout) + sum.cross;
  const Eigen::MatrixXd cross = slope_.transpose() * sum.cross;
  ReducedSum reduced;
  reduced.matrix = slope_.transpose() * half + cross.transpose() + sum.coefficients;
  reduced.gradient = sum.coefficient_gradient + slope_.transpose() * sum.pose_gradient +
                     half.transpose() * offset_;
  return reduced;
}

Eigen::VectorXd variances_of_poses(const SystemSum& sum, const SystemLayout& layout) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Eigen::VectorXd variances = Eigen::VectorXd::Constant(layout.poses, kNone);
  if (layout.poses == 0) return variances;
  const Factors factors(matrix_of(sum.poses, layout));
  if (factors.info() != Eigen::Success) return variances;
  for (Eigen::Index pose = 0; pose < layout.poses; pose += 6) {
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(layout.poses, 6);
    unit.middleRows<6>(pose).setIdentity();
    const Eigen::MatrixXd columns = factors.solve(unit);
    variances.segment<6>(pose) = columns.middleRows<6>(pose).diagonal();
  }
  return variances;
}

void add_common_motion(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
                       ReducedSum& all) {
  const auto parts = coefficients_of(pair, sensors, layout);
  const Eigen::MatrixXd motion = common_motion(pair, parts[0].count);
  for (const Part& a : parts)
    for (const Part& b : parts)
      all.matrix.block(a.to, b.to, a.count, b.count) +=
          motion.block(a.from - 6, b.from - 6, a.count, b.count);
}

}  // namespace relief::registration
