#include "registration/posegraph/refinement/pose_graph_problem.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Core>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include "registration/pairwise/normal_equations.h"
#include "registration/posegraph/pairs/pair_terms.h"
#include "registration/posegraph/sparse_solver.h"

namespace relief::registration {

namespace {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

// Both directions of a pair by the motion of its first view relative to its second.
struct EdgeTerms {
  NormalEquations sum;
  double losses = 0.0;
};
using Edges = std::map<std::pair<std::size_t, std::size_t>, EdgeTerms>;

Edges edges_of(const std::vector<PairInformation>& pairs, double step_gain) {
  Edges edges;
  for (const auto& pair : pairs) {
    if (pair.information.isZero(0.0)) continue;
    EdgeTerms& edge = edges[std::minmax(pair.source, pair.target)];
    edge.sum.matrix += step_gain * (pair.information - pair.independent) + pair.independent;
    edge.sum.gradient += pair.source < pair.target ? pair.score : RigidTangent(-pair.score);
    edge.losses += pair.losses;
  }
  return edges;
}

// f + D (x_s - x_t), with the tangents as products of `source` or `target` and the parameters.
class EdgeCost : public ceres::SizedCostFunction<7, 6, 6> {
 public:
  EdgeCost(CompressedTerms terms, const Matrix6d& source, const Matrix6d& target)
      : terms_(std::move(terms)),
        by_source_(terms_.derivative * source),
        by_target_(-terms_.derivative * target) {}

  bool Evaluate(double const* const* tangents, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector6d> source(tangents[0]), target(tangents[1]);
    const Eigen::Matrix<double, 7, 1> r =
        terms_.residuals + by_source_ * source + by_target_ * target;
    std::copy_n(r.data(), r.size(), residuals);
    if (!jacobians) return true;
    if (jacobians[0]) std::copy_n(by_source_.data(), by_source_.size(), jacobians[0]);
    if (jacobians[1]) std::copy_n(by_target_.data(), by_target_.size(), jacobians[1]);
    return true;
  }

 private:
  using Derivative = Eigen::Matrix<double, 7, 6, Eigen::RowMajor>;
  CompressedTerms terms_;
  Derivative by_source_, by_target_;
};

}  // namespace

SymmetricBlocks information_blocks(const std::vector<PairInformation>& pairs,
                                   const AllowedMotions& allowed, double step_gain) {
  SymmetricBlocks matrix;
  for (std::size_t i = 0; i < allowed.prior.size(); ++i)
    matrix[{i, i}] = allowed.prior[i].asDiagonal();
  for (const auto& [views, edge] : edges_of(pairs, step_gain)) {
    const CompressedTerms terms = compress(edge.sum, edge.losses);
    Matrix6d block = terms.derivative.transpose() * terms.derivative;
    if (!terms.residuals.allFinite()) block.setConstant(std::numeric_limits<double>::quiet_NaN());
    const Matrix6d &first = allowed.projection[views.first],
                   &second = allowed.projection[views.second];
    matrix[{views.first, views.first}] += first.transpose() * block * first;
    matrix[{views.second, views.second}] += second.transpose() * block * second;
    matrix[views] = -first.transpose() * block * second;
  }
  return matrix;
}

struct PoseGraphProblem::Parts {
  std::vector<bool> held;
  std::vector<Matrix6d> projection;
  // What each component is known to with all others held: radians and units differ by orders of
  // magnitude.
  std::vector<RigidTangent> scale;
  std::vector<RigidTangent> values;  // Tangents in units of `scale`.
  bool finite = true;
  ceres::Problem problem;
  ceres::Covariance inverse{ceres::Covariance::Options()};
};

PoseGraphProblem::PoseGraphProblem(const std::vector<PairInformation>& pairs,
                                   const AllowedMotions& allowed, const std::vector<bool>& held,
                                   double step_gain)
    : parts_(std::make_unique<Parts>()) {
  const Edges edges = edges_of(pairs, step_gain);
  parts_->held = held;
  parts_->projection = allowed.projection;
  parts_->values.assign(held.size(), RigidTangent::Zero());
  std::vector<RigidTangent> precision = allowed.prior;
  for (const auto& [views, edge] : edges) {
    precision[views.first] += edge.sum.matrix.diagonal().cwiseMax(0.0);
    precision[views.second] += edge.sum.matrix.diagonal().cwiseMax(0.0);
  }
  for (const RigidTangent& of : precision) parts_->scale.push_back(of.cwiseSqrt().cwiseInverse());
  for (std::size_t i = 0; i < held.size(); ++i) {
    double* const tangent = parts_->values[i].data();
    parts_->problem.AddParameterBlock(tangent, 6);
    if (held[i]) parts_->problem.SetParameterBlockConstant(tangent);
    const RigidTangent root = allowed.prior[i].cwiseSqrt().cwiseProduct(parts_->scale[i]);
    parts_->problem.AddResidualBlock(
        new ceres::NormalPrior(root.asDiagonal().toDenseMatrix(), Vector6d::Zero()), nullptr,
        tangent);
  }
  for (const auto& [views, edge] : edges) {
    const auto [a, b] = views;
    if (held[a] && held[b]) continue;
    auto terms = compress(edge.sum, edge.losses);
    parts_->finite = parts_->finite && terms.residuals.allFinite();
    parts_->problem.AddResidualBlock(
        new EdgeCost(std::move(terms), allowed.projection[a] * parts_->scale[a].asDiagonal(),
                     allowed.projection[b] * parts_->scale[b].asDiagonal()),
        nullptr, parts_->values[a].data(), parts_->values[b].data());
  }
}

PoseGraphProblem::~PoseGraphProblem() = default;
PoseGraphProblem::PoseGraphProblem(PoseGraphProblem&&) noexcept = default;
PoseGraphProblem& PoseGraphProblem::operator=(PoseGraphProblem&&) noexcept = default;

PoseGraphStep PoseGraphProblem::minimise() {
  constexpr int kSteps = 3;  // The first is exact but for rounding; the others say so.
  PoseGraphStep step;
  step.summary.stage = SolverStage::kPoseGraph;
  step.tangents.assign(parts_->values.size(), RigidTangent::Zero());
  if (!parts_->finite) {
    step.summary.message = "the residuals of a pair are not finite";
    return step;
  }
  for (RigidTangent& value : parts_->values) value.setZero();
  step.summary =
      solve_sparse(parts_->problem,
                   {.stage = SolverStage::kPoseGraph, .max_iterations = kSteps, .quadratic = true});
  if (!step.usable()) return step;
  for (std::size_t i = 0; i < parts_->values.size(); ++i)
    if (!parts_->held[i])
      step.tangents[i] = parts_->projection[i] * parts_->scale[i].cwiseProduct(parts_->values[i]);
  return step;
}

bool PoseGraphProblem::invert() {
  if (!parts_->finite) return false;
  std::vector<std::pair<const double*, const double*>> blocks;
  for (std::size_t i = 0; i < parts_->values.size(); ++i)
    for (std::size_t j = i; j < parts_->values.size() && !parts_->held[i]; ++j)
      if (!parts_->held[j]) blocks.emplace_back(parts_->values[i].data(), parts_->values[j].data());
  return blocks.empty() || parts_->inverse.Compute(blocks, &parts_->problem);
}

Matrix6d PoseGraphProblem::inverse(std::size_t row, std::size_t column) const {
  if (parts_->held[row] || parts_->held[column]) return Matrix6d::Zero();
  RowMajor6d block = RowMajor6d::Zero();
  parts_->inverse.GetCovarianceBlock(parts_->values[row].data(), parts_->values[column].data(),
                                     block.data());
  return parts_->scale[row].asDiagonal() * block * parts_->scale[column].asDiagonal();
}

}  // namespace relief::registration
