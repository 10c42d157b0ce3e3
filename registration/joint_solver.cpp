#include "registration/joint_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
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

}  // namespace relief
