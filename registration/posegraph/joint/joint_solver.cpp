#include "registration/posegraph/joint/joint_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <ceres/ceres.h>

#include "registration/posegraph/joint/pose_parameters.h"
#include "registration/posegraph/pairs/pair_terms.h"
#include "registration/posegraph/sparse_solver.h"
#include "scan/base/memory/paged_lists.h"
#include "scan/base/parallel.h"
#include "scan/base/parallel_batches.h"

namespace relief::registration {

namespace {

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

// The terms of a directed pair, while the next ones are made.
struct MadeTerms {
  std::size_t source = 0, target = 0;
  std::vector<PlaneResidual> planes;
  std::vector<NormalResidual> normals;
};

MadeTerms terms_of(const DirectedMatches& pair, const ViewSurface& source,
                   const ViewSurface& target, const RigidMotion& source_from_target) {
  MadeTerms terms{pair.source, pair.target, {}, {}};
  terms.planes.reserve(pair.found.items.size());
  terms.normals.reserve(pair.normals.items.size());
  for (const Correspondence& c : pair.found.items)
    terms.planes.push_back({c.source.point - source.centre(), c.target.point - target.centre(),
                            c.target.normal, std::sqrt(c.weight) / pair.found.sigma});
  for (const NormalMatch& match : pair.normals.items) {
    const PlaneResidual& plane = terms.planes[match.correspondence];
    terms.normals.push_back({plane.source, plane.target, source_from_target.linear() * match.normal,
                             match.basis, match.gradient(),
                             std::sqrt(match.weight) / pair.normals.effective_sigma});
  }
  return terms;
}

// The directed pairs while Ceres varies the poses: all compressed in parallel whenever it has moved
// them, each summed up in its own order.
class CompressedPairs : public ceres::EvaluationCallback {
 public:
  explicit CompressedPairs(const std::vector<PoseParameters>& poses) : poses_(poses) {}

  void add(const MadeTerms& terms) {
    pairs_.push_back({terms.source, terms.target, {}});
    planes_.add(terms.planes);
    normals_.add(terms.normals);
  }

  // Compresses all at the first poses. Whether they are finite: Ceres would print what is not.
  bool start() {
    compress();
    started_ = true;
    return std::all_of(pairs_.begin(), pairs_.end(),
                       [](const Pair& pair) { return pair.now.residuals.allFinite(); });
  }

  // With derivatives even if only the cost is asked for: most steps are taken, and then they are.
  void PrepareForEvaluation(bool, bool poses_moved) override {
    if (poses_moved && !std::exchange(started_, false)) compress();
  }

  std::size_t size() const { return pairs_.size(); }
  std::size_t source(std::size_t i) const { return pairs_[i].source; }
  std::size_t target(std::size_t i) const { return pairs_[i].target; }
  const CompressedTerms& now(std::size_t i) const { return pairs_[i].now; }

 private:
  void compress() {
    parallel_for(pairs_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Pair& pair = pairs_[i];
        pair.now = PairTerms{planes_[i], normals_[i]}.compress(
            relative_pose(poses_[pair.source], poses_[pair.target]));
      }
    });
  }

  struct Pair {
    std::size_t source, target;
    CompressedTerms now;
  };
  const std::vector<PoseParameters>& poses_;
  std::vector<Pair> pairs_;
  PagedLists<PlaneResidual> planes_;  // Of each pair.
  PagedLists<NormalResidual> normals_;
  bool started_ = false;  // Whether they are those of the first poses, not asked for yet.
};

class PairCost : public ceres::SizedCostFunction<7, 7, 7> {
 public:
  PairCost(const CompressedPairs& pairs, std::size_t index) : pairs_(pairs), index_(index) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const CompressedTerms& terms = pairs_.now(index_);
    std::copy_n(terms.residuals.data(), 7, residuals);
    if (!jacobians) return true;
    const PoseParameters source(poses[0]), target(poses[1]);
    if (jacobians[0]) write(terms.derivative * tangent_by_source(source, target), jacobians[0]);
    if (jacobians[1]) write(terms.derivative * tangent_by_target(target), jacobians[1]);
    return true;
  }

 private:
  using Jacobian = Eigen::Matrix<double, 7, 7, Eigen::RowMajor>;
  static void write(const Jacobian& jacobian, double* out) {
    std::copy_n(jacobian.data(), 49, out);
  }

  const CompressedPairs& pairs_;
  std::size_t index_;
};

}  // namespace

SolverSummary solve_poses(const std::vector<ViewSurface>& surfaces, std::size_t pair_count,
                          const MatchDirectedPair& match, const std::vector<bool>& fixed,
                          const JointSolverOptions& options,
                          std::vector<RigidMotion>& world_from_view) {
  PoseBlocks blocks = pose_blocks(surfaces, world_from_view);
  CompressedPairs pairs(blocks.values);
  // None of pairs that share nothing or cannot move.
  const auto terms_of_pair = [&](std::size_t i) {
    const DirectedMatches pair = match(i);
    if (fixed[pair.source] && fixed[pair.target]) return MadeTerms();
    return terms_of(pair, surfaces[pair.source], surfaces[pair.target],
                    world_from_view[pair.source].inverse() * world_from_view[pair.target]);
  };
  parallel_map_in_batches<MadeTerms>(pair_count, kMatchedAtOnce, terms_of_pair,
                                     [&](std::size_t, const MadeTerms& terms) {
                                       if (!terms.planes.empty()) pairs.add(terms);
                                     });
  if (!pairs.start())
    return {.termination = SolverTermination::kFailed,
            .message = "the residuals of a pair are not finite"};
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> rigid;
  ceres::Problem::Options problem_options;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.evaluation_callback = &pairs;
  ceres::Problem problem(problem_options);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    problem.AddParameterBlock(blocks.values[i].data(), 7, &rigid);
    if (fixed[i]) problem.SetParameterBlockConstant(blocks.values[i].data());
  }
  for (std::size_t i = 0; i < pairs.size(); ++i)
    problem.AddResidualBlock(new PairCost(pairs, i), nullptr, blocks.values[pairs.source(i)].data(),
                             blocks.values[pairs.target(i)].data());
  SolverSummary summary = solve_sparse(problem, {.max_iterations = options.max_iterations});
  if (summary.termination == SolverTermination::kFailed) return summary;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (!fixed[i])
      world_from_view[i] =
          pose_from_parameters(blocks.values[i], surfaces[i].centre(), blocks.world_centre);
  return summary;
}

}  // namespace relief::registration
