#include "registration/calibration/estimation/calibration_problem.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include "registration/posegraph/pairs/quadratic_residuals.h"
#include "registration/posegraph/sparse_solver.h"

namespace relief::registration {

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// What a directed pair knows of one block of unknowns: its residuals are linear in the block.
struct BlockDerivative {
  double* block = nullptr;
  RowMajor derivative;
};

// f + sum of D_b x_b over the blocks.
class LinearCost : public ceres::CostFunction {
 public:
  LinearCost(Eigen::VectorXd residuals, std::vector<BlockDerivative> blocks)
      : residuals_(std::move(residuals)), blocks_(std::move(blocks)) {
    set_num_residuals(static_cast<int>(residuals_.size()));
    for (const BlockDerivative& of : blocks_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(of.derivative.cols()));
  }

  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    Eigen::VectorXd r = residuals_;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const RowMajor& derivative = blocks_[b].derivative;
      r += derivative * Eigen::Map<const Eigen::VectorXd>(values[b], derivative.cols());
      if (jacobians && jacobians[b])
        std::copy_n(derivative.data(), derivative.size(), jacobians[b]);
    }
    std::copy_n(r.data(), r.size(), residuals);
    return true;
  }

 private:
  Eigen::VectorXd residuals_;
  std::vector<BlockDerivative> blocks_;
};

// The parameters of one sensor or one view, which Ceres takes as one block.
struct ErrorBlock {
  std::vector<std::size_t> parameters;  // Indices into the model's.
  std::vector<double> step;
};

class Problem {
 public:
  Problem(const std::vector<PairSums>& pairs, const Sensors& sensors, const ErrorModel& model,
          const std::vector<bool>& held)
      : sensors_(sensors),
        model_(model),
        held_(held),
        tangents_(held.size(), RigidTangent::Zero()),
        of_view_(held.size()),
        of_sensor_(sensors.models.size()) {
    gather_blocks();
    scale_poses(pairs);
    for (std::size_t i = 0; i < held.size(); ++i) {
      problem_.AddParameterBlock(tangents_[i].data(), 6);
      if (held[i]) problem_.SetParameterBlockConstant(tangents_[i].data());
      add_prior(tangents_[i].data(), Eigen::VectorXd::Constant(6, kWeakPrior),
                Eigen::VectorXd::Zero(6));
    }
    for (auto* blocks : {&of_sensor_, &of_view_})
      for (ErrorBlock& block : *blocks) add_prior_of(block);
    for (const PairSums& pair : pairs) add_pair(pair);
  }

  CalibrationStep minimise() {
    constexpr int kSteps = 3;  // The first is exact but for rounding; the others say so.
    CalibrationStep result;
    result.tangents.assign(held_.size(), RigidTangent::Zero());
    result.errors.assign(model_.parameters.size(), 0.0);
    result.summary.stage = SolverStage::kCalibration;
    if (!finite_) {
      result.summary.message = "the residuals of a pair are not finite";
      return result;
    }
    result.summary = solve_sparse(
        problem_,
        {.stage = SolverStage::kCalibration, .max_iterations = kSteps, .quadratic = true});
    if (!result.usable()) return result;
    for (std::size_t i = 0; i < held_.size(); ++i)
      if (!held_[i]) result.tangents[i] = scale_.cwiseProduct(tangents_[i]);
    for (const auto* blocks : {&of_sensor_, &of_view_})
      for (const ErrorBlock& block : *blocks)
        for (std::size_t k = 0; k < block.parameters.size(); ++k)
          result.errors[block.parameters[k]] = block.step[k];
    return result;
  }

 private:
  // Of poses, in units of what all pairs together determine a component to: keeps finite what
  // nothing determines.
  static constexpr double kWeakPrior = 1e-6;

  void gather_blocks() {
    for (std::size_t p = 0; p < model_.parameters.size(); ++p) {
      const ErrorParameter& parameter = model_.parameters[p];
      auto& blocks = model_.choices[parameter.choice].per_view ? of_view_ : of_sensor_;
      blocks[parameter.owner].parameters.push_back(p);
      blocks[parameter.owner].step.push_back(0.0);
    }
  }

  // Radians and units differ by orders of magnitude.
  void scale_poses(const std::vector<PairSums>& pairs) {
    Vector6d precision = Vector6d::Constant(1e-300);
    for (const PairSums& pair : pairs)
      for (const QuadraticSum& fold : pair.folds)
        precision += fold.matrix.diagonal().head<6>().cwiseMax(0.0);
    scale_ = (precision / static_cast<double>(std::max<std::size_t>(1, pairs.size())))
                 .cwiseSqrt()
                 .cwiseInverse();
  }

  void add_prior(double* block, const Eigen::VectorXd& root, const Eigen::VectorXd& mean) {
    problem_.AddResidualBlock(new ceres::NormalPrior(root.asDiagonal().toDenseMatrix(), mean),
                              nullptr, block);
  }

  // Of the whole coefficients, which the step adds to.
  void add_prior_of(ErrorBlock& block) {
    if (block.parameters.empty()) return;
    const auto size = static_cast<Eigen::Index>(block.parameters.size());
    Eigen::VectorXd mean(size);
    for (Eigen::Index k = 0; k < size; ++k)
      mean[k] = -model_.parameters[block.parameters[static_cast<std::size_t>(k)]].value;
    problem_.AddParameterBlock(block.step.data(), static_cast<int>(size));
    add_prior(block.step.data(), Eigen::VectorXd::Constant(size, 1.0 / model_.prior_deviation),
              mean);
  }

  // The columns of a pair's derivative by the parameters of a block, for its source and target.
  RowMajor by_block(const ErrorBlock& block, const PairSums& pair,
                    const Eigen::MatrixXd& derivative, bool source, bool target) const {
    RowMajor columns =
        RowMajor::Zero(derivative.rows(), static_cast<Eigen::Index>(block.parameters.size()));
    const auto source_terms =
        static_cast<Eigen::Index>(sensors_.models[sensors_.of_view[pair.source]].terms());
    for (std::size_t k = 0; k < block.parameters.size(); ++k) {
      const auto term = static_cast<Eigen::Index>(model_.parameters[block.parameters[k]].term);
      auto column = columns.col(static_cast<Eigen::Index>(k));
      if (source) column += derivative.col(6 + term);
      if (target) column += derivative.col(6 + source_terms + term);
    }
    return columns;
  }

  void add_pair(const PairSums& pair) {
    if (pair.deviation <= 0.0) return;
    QuadraticSum sum = pair.folds[0];
    for (std::size_t f = 1; f < kFolds; ++f) sum += pair.folds[f];
    const auto terms = quadratic_residuals<Eigen::Dynamic>(sum.matrix, sum.gradient, sum.squares);
    finite_ = finite_ && terms.residuals.allFinite();
    const RowMajor of_pose = terms.derivative.leftCols<6>() * scale_.asDiagonal();
    std::vector<BlockDerivative> blocks = {{tangents_[pair.source].data(), of_pose},
                                           {tangents_[pair.target].data(), -of_pose}};
    const auto add = [&](ErrorBlock& block, bool source, bool target) {
      if (!block.parameters.empty())
        blocks.push_back(
            {block.step.data(), by_block(block, pair, terms.derivative, source, target)});
    };
    const std::size_t s = sensors_.of_view[pair.source], t = sensors_.of_view[pair.target];
    add(of_sensor_[s], true, s == t);
    if (s != t) add(of_sensor_[t], false, true);
    add(of_view_[pair.source], true, false);
    add(of_view_[pair.target], false, true);
    std::vector<double*> addresses;
    for (const BlockDerivative& block : blocks) addresses.push_back(block.block);
    problem_.AddResidualBlock(new LinearCost(terms.residuals, std::move(blocks)), nullptr,
                              addresses);
    add_common_motion(pair);
  }

  // Errors per view average out where views overlap.
  void add_common_motion(const PairSums& pair) {
    ErrorBlock &source = of_view_[pair.source], &target = of_view_[pair.target];
    if (source.parameters.empty() || target.parameters.empty()) return;
    const auto terms =
        static_cast<Eigen::Index>(sensors_.models[sensors_.of_view[pair.source]].terms());
    const Eigen::MatrixXd motion = common_motion(pair, terms);
    Eigen::VectorXd values = Eigen::VectorXd::Zero(motion.rows());
    const auto set_values = [&](const ErrorBlock& block, Eigen::Index first) {
      for (const std::size_t p : block.parameters)
        values[first + static_cast<Eigen::Index>(model_.parameters[p].term)] =
            model_.parameters[p].value;
    };
    set_values(source, 0);
    set_values(target, terms);
    const auto residuals =
        quadratic_residuals<Eigen::Dynamic>(motion, motion * values, values.dot(motion * values));
    Eigen::MatrixXd derivative(residuals.derivative.rows(), 6 + motion.cols());
    derivative << Eigen::MatrixXd::Zero(residuals.derivative.rows(), 6), residuals.derivative;
    problem_.AddResidualBlock(
        new LinearCost(residuals.residuals,
                       {{source.step.data(), by_block(source, pair, derivative, true, false)},
                        {target.step.data(), by_block(target, pair, derivative, false, true)}}),
        nullptr, source.step.data(), target.step.data());
  }

  const Sensors& sensors_;
  const ErrorModel& model_;
  const std::vector<bool>& held_;
  Vector6d scale_;
  std::vector<RigidTangent> tangents_;  // In units of `scale_`.
  std::vector<ErrorBlock> of_view_, of_sensor_;
  bool finite_ = true;
  ceres::Problem problem_;
};

}  // namespace

CalibrationStep solve_calibration(const std::vector<PairSums>& pairs, const Sensors& sensors,
                                  const ErrorModel& model, const std::vector<bool>& held) {
  return Problem(pairs, sensors, model, held).minimise();
}

}  // namespace relief::registration
