#include "registration/joint_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <ceres/ceres.h>

#include "registration/normal_residual.h"
#include "registration/plane_residual.h"
#include "registration/robust.h"

namespace relief {

namespace {

class PlaneCost : public ceres::SizedCostFunction<1, 7, 7> {
 public:
  explicit PlaneCost(const PlaneResidual& residual) : residual_(residual) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    residuals[0] = residual_.evaluate(poses[0], poses[1], jacobians ? jacobians[0] : nullptr,
                                      jacobians ? jacobians[1] : nullptr);
    return true;
  }

 private:
  PlaneResidual residual_;
};

class NormalCost : public ceres::SizedCostFunction<2, 7, 7> {
 public:
  explicit NormalCost(const NormalResidual& residual) : residual_(residual) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const Eigen::Vector2d values = residual_.evaluate(
        poses[0], poses[1], jacobians ? jacobians[0] : nullptr, jacobians ? jacobians[1] : nullptr);
    std::copy_n(values.data(), 2, residuals);
    return true;
  }

 private:
  NormalResidual residual_;
};

// The poses of all views as parameters about a common centre.
struct PoseBlocks {
  Eigen::Vector3d world_centre = Eigen::Vector3d::Zero();
  std::vector<PoseParameters> values;
};

PoseBlocks pose_blocks(const std::vector<ViewSurface>& surfaces,
                       const std::vector<RigidMotion>& world_from_view) {
  PoseBlocks blocks;
  const Eigen::Vector3d first = world_from_view.front() * surfaces.front().centre();
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    blocks.world_centre += world_from_view[i] * surfaces[i].centre() - first;
  blocks.world_centre = first + blocks.world_centre / static_cast<double>(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    blocks.values.push_back(
        pose_parameters(world_from_view[i], surfaces[i].centre(), blocks.world_centre));
  return blocks;
}

PlaneResidual plane_residual(const Correspondence& c, double sigma, const ViewSurface& source,
                             const ViewSurface& target) {
  return {c.source.point - source.centre(), c.target.point - target.centre(), c.target.normal,
          std::sqrt(c.weight) / sigma};
}

NormalResidual normal_residual(const NormalMatch& match, const DirectedMatches& pair,
                               const ViewSurface& source, const ViewSurface& target,
                               const RigidMotion& source_from_target) {
  const Correspondence& c = pair.found.items[match.correspondence];
  return {c.source.point - source.centre(),
          c.target.point - target.centre(),
          source_from_target.linear() * match.normal,
          match.basis,
          match.gradient(),
          std::sqrt(match.weight) / pair.normals.effective_sigma};
}

// What a pose without any constraint is known to: one radian, one radius of the view.
RigidTangent prior_deviation(const ViewSurface& surface) {
  RigidTangent deviation = RigidTangent::Ones();
  deviation.tail<3>() *= surface.radius();
  return deviation;
}

// The same of the normals: a motion of the target undoes one of the source, so the 6x6 matrix of
// relative motions, about a centre between, is moved to the centre of either view.
Eigen::Matrix<double, 12, 12> normal_information(const DirectedMatches& pair,
                                                 const std::vector<ViewSurface>& surfaces,
                                                 const std::vector<RigidMotion>& world_from_view) {
  Eigen::Matrix<double, 12, 12> information = Eigen::Matrix<double, 12, 12>::Zero();
  const RigidMotion& target_pose = world_from_view[pair.target];
  const Eigen::Vector3d at_source = world_from_view[pair.source] * surfaces[pair.source].centre();
  const Eigen::Vector3d at_target = target_pose * surfaces[pair.target].centre();
  const double precision = 1.0 / (pair.normals.effective_sigma * pair.normals.effective_sigma);
  for (const NormalMatch& in_target : pair.normals.items) {
    const NormalMatch match = in_target.moved(target_pose);
    for (int k = 0; k < 2; ++k) {
      const auto row = [&](const Eigen::Matrix<double, 3, 2>& gradient) {
        Eigen::Matrix<double, 12, 1> j;
        j << match.derivative(k, gradient, at_source), -match.derivative(k, gradient, at_target);
        return j;
      };
      const auto s = row(match.source_gradient), t = row(match.target_gradient);
      const double weight = precision * match.weight *
                            cauchy_weight(match.residual[k] / pair.normals.sigma, kCauchyScale);
      information += 0.5 * weight * (s * t.transpose() + t * s.transpose());
    }
  }
  return information;
}

}  // namespace

void solve_poses(const std::vector<ViewSurface>& surfaces,
                 const std::vector<DirectedMatches>& matches, const std::vector<bool>& fixed,
                 const JointSolverOptions& options, std::vector<RigidMotion>& world_from_view) {
  PoseBlocks blocks = pose_blocks(surfaces, world_from_view);
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.disable_all_safety_checks = true;  // They cost as much as a step.
  ceres::CauchyLoss loss(kCauchyScale);
  ceres::CauchyLoss normal_loss(std::sqrt(2.0) * kCauchyScale);  // Of two residuals at once.
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> rigid;
  ceres::Problem problem(problem_options);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    problem.AddParameterBlock(blocks.values[i].data(), 7, &rigid);
    if (fixed[i]) problem.SetParameterBlockConstant(blocks.values[i].data());
  }
  for (const auto& pair : matches) {
    for (const auto& c : pair.found.items) {
      auto* cost = new PlaneCost(
          plane_residual(c, pair.found.sigma, surfaces[pair.source], surfaces[pair.target]));
      problem.AddResidualBlock(cost, &loss, blocks.values[pair.source].data(),
                               blocks.values[pair.target].data());
    }
    const RigidMotion source_from_target =
        world_from_view[pair.source].inverse() * world_from_view[pair.target];
    for (const auto& match : pair.normals.items) {
      auto* cost = new NormalCost(normal_residual(match, pair, surfaces[pair.source],
                                                  surfaces[pair.target], source_from_target));
      problem.AddResidualBlock(cost, &normal_loss, blocks.values[pair.source].data(),
                               blocks.values[pair.target].data());
    }
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;  // Parallel sums would depend on the number of threads.
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (!fixed[i])
      world_from_view[i] =
          pose_from_parameters(blocks.values[i], surfaces[i].centre(), blocks.world_centre);
}

std::vector<RigidTangent> pose_deviations(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<DirectedMatches>& matches,
                                          const std::vector<bool>& fixed,
                                          const std::vector<RigidMotion>& world_from_view) {
  const PoseBlocks blocks = pose_blocks(surfaces, world_from_view);
  const auto size = static_cast<Eigen::Index>(6 * surfaces.size());
  // (R6): the information J^T W J of whitened residuals, plus the prior.
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const RigidTangent precision =
        prior_deviation(surfaces[i]).cwiseMax(1e-300).array().square().inverse();
    information.diagonal().segment<6>(static_cast<Eigen::Index>(6 * i)) = precision;
  }
  for (const auto& pair : matches) {
    const auto s = static_cast<Eigen::Index>(6 * pair.source);
    const auto t = static_cast<Eigen::Index>(6 * pair.target);
    Eigen::Matrix<double, 12, 12> block = Eigen::Matrix<double, 12, 12>::Zero();
    for (const auto& c : pair.found.items) {
      const PlaneResidual residual =
          plane_residual(c, pair.found.sigma, surfaces[pair.source], surfaces[pair.target]);
      RigidTangent by_source, by_target;
      residual.tangents(blocks.values[pair.source].data(), blocks.values[pair.target].data(),
                        by_source, by_target);
      Eigen::Matrix<double, 12, 1> j;
      j << by_source, by_target;
      block += cauchy_weight(residual.scale * c.distance, kCauchyScale) * j * j.transpose();
    }
    block += normal_information(pair, surfaces, world_from_view);
    information.block<6, 6>(s, s) += block.topLeftCorner<6, 6>();
    information.block<6, 6>(s, t) += block.topRightCorner<6, 6>();
    information.block<6, 6>(t, s) += block.bottomLeftCorner<6, 6>();
    information.block<6, 6>(t, t) += block.bottomRightCorner<6, 6>();
  }
  std::vector<RigidTangent> deviations(surfaces.size(), RigidTangent::Zero());
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (Eigen::Index k = 0; k < 6 && !fixed[i]; ++k)
      free.push_back(static_cast<Eigen::Index>(6 * i) + k);
  if (free.empty()) return deviations;
  const Eigen::MatrixXd reduced = information(free, free);
  // Scaled to a unit diagonal: radians and units differ by orders of magnitude.
  const Eigen::VectorXd scale = reduced.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * reduced * scale.asDiagonal();
  const Eigen::MatrixXd covariance =
      scaled.ldlt().solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    deviations[static_cast<std::size_t>(free[k] / 6)][free[k] % 6] =
        scale[i] * std::sqrt(std::max(0.0, covariance(i, i)));
  }
  return deviations;
}

}  // namespace relief
