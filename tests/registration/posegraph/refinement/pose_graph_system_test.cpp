#include "registration/posegraph/refinement/pose_graph_system.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using Links = std::vector<std::pair<std::size_t, std::size_t>>;

constexpr double kGain = 0.8;
const Eigen::Vector3d kCentre(3.0, -2.0, 1.0);

// Views of which only the poses and the sizes matter, and directed pairs with made-up residuals.
struct Graph {
  Graph(std::size_t views, const Links& links, std::vector<bool> held_views, int residuals = 40)
      : held(std::move(held_views)), scores(views) {
    for (const RangeView& view :
         testing::ring_of_views({.views = static_cast<int>(views), .pixels = 40})) {
      poses.push_back(view.world_from_view);
      surfaces.emplace_back(view);
    }
    for (const auto& [a, b] : links) {
      add(a, b, residuals);
      add(b, a, residuals);
    }
  }

  void add(std::size_t source, std::size_t target, int residuals) {
    PairInformation pair;
    pair.source = source;
    pair.target = target;
    std::map<std::uint64_t, RigidTangent> patches;
    for (int i = 0; i < residuals; ++i) {
      RigidTangent j;
      for (double& value : j) value = 1e2 * normal(generator);
      j.head<3>() *= 50.0;
      const double r = normal(generator);
      pair.information += j * j.transpose();
      pair.score += r * j;
      pair.losses += r * r;
      patches.try_emplace(static_cast<std::uint64_t>(i % 13), RigidTangent::Zero()).first->second +=
          r * j;
    }
    pair.independent = 0.3 * pair.information;
    for (const auto& [patch, score] : patches) pair.patches.push_back({patch, score});
    scores.add(pair);
    pairs.push_back(std::move(pair));
  }

  PoseGraphSystem system() {
    pointers = pointers_to(surfaces);
    return PoseGraphSystem(pointers, pairs, held, kCentre);
  }

  Eigen::Index rows() const { return static_cast<Eigen::Index>(6 * surfaces.size()); }

  std::mt19937 generator{5};
  std::normal_distribution<double> normal;
  std::vector<bool> held;
  std::vector<RigidMotion> poses;
  std::vector<ViewSurface> surfaces;
  std::vector<const ViewSurface*> pointers;
  std::vector<PairInformation> pairs;
  ClusterScores scores;
};

Eigen::Index row_of(std::size_t view) { return static_cast<Eigen::Index>(6 * view); }

// More digits than the solver has, as the prior knows a billionth of what the pairs know.
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

LongMatrix inverse_of(const Eigen::MatrixXd& matrix) {
  return LongMatrix(matrix.cast<long double>()).partialPivLu().inverse();
}

// What (R11) and (R12) say, as dense matrices of all poses.
class DenseReference {
 public:
  explicit DenseReference(Graph& graph) : graph_(graph) {
    for (std::size_t i = 0; i < graph.held.size(); ++i)
      for (Eigen::Index k = 0; k < 6 && !graph.held[i]; ++k) free_.push_back(row_of(i) + k);
  }

  Eigen::MatrixXd prior() const {
    Eigen::VectorXd precision = Eigen::VectorXd::Ones(graph_.rows());
    for (std::size_t i = 0; i < graph_.surfaces.size(); ++i)
      precision.segment<3>(row_of(i) + 3)
          .setConstant(1.0 / (graph_.surfaces[i].radius() * graph_.surfaces[i].radius()));
    return precision.asDiagonal();
  }

  Eigen::MatrixXd information(double gain) const {
    Eigen::MatrixXd sum = prior();
    for (const auto& pair : graph_.pairs)
      sum += edge(pair, gain * (pair.information - pair.independent) + pair.independent);
    return sum;
  }

  Eigen::MatrixXd scatter() const {
    std::map<std::uint64_t, Eigen::VectorXd> patches;
    graph_.scores.for_each_cluster(
        [&](std::uint64_t patch, std::span<const ClusterScores::Entry> entries) {
          for (const auto& entry : entries)
            patches.try_emplace(patch, Eigen::VectorXd::Zero(graph_.rows()))
                .first->second.segment<6>(row_of(entry.view)) += entry.score;
        });
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(graph_.rows(), graph_.rows());
    for (const auto& [patch, score] : patches) sum += score * score.transpose();
    const double m = static_cast<double>(patches.size()), d = static_cast<double>(free_.size());
    sum *=
        graph_.system().variance_inflation(graph_.scores) * std::min(2.0, m / std::max(1.0, m - d));
    for (const auto& pair : graph_.pairs) sum += edge(pair, pair.independent);
    return sum + prior();
  }

  Eigen::VectorXd step() const {
    Eigen::VectorXd score = Eigen::VectorXd::Zero(graph_.rows());
    for (const auto& pair : graph_.pairs) {
      score.segment<6>(row_of(pair.source)) += pair.score;
      score.segment<6>(row_of(pair.target)) -= pair.score;
    }
    Eigen::VectorXd result = Eigen::VectorXd::Zero(graph_.rows());
    const LongMatrix inverse = inverse_of(information(1.0)(free_, free_));
    result(free_) = -(inverse * score(free_).cast<long double>()).cast<double>();
    return result;
  }

  Eigen::MatrixXd covariance() const {
    const LongMatrix inverse = inverse_of(information(kGain)(free_, free_));
    const LongMatrix scatter_of_free = scatter()(free_, free_).cast<long double>();
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(graph_.rows(), graph_.rows());
    result(free_, free_) = (inverse * scatter_of_free * inverse).cast<double>();
    Eigen::MatrixXd about_views = Eigen::MatrixXd::Identity(graph_.rows(), graph_.rows());
    for (std::size_t i = 0; i < graph_.poses.size(); ++i) {
      const Eigen::Vector3d centre = graph_.poses[i] * graph_.surfaces[i].centre() - kCentre;
      for (Eigen::Index k = 0; k < 3; ++k)
        about_views.block<3, 1>(row_of(i) + 3, row_of(i) + k) =
            Eigen::Vector3d::Unit(k).cross(centre);
    }
    return about_views * result * about_views.transpose();
  }

 private:
  Eigen::MatrixXd edge(const PairInformation& pair, const Matrix6d& block) const {
    Eigen::MatrixXd incidence = Eigen::MatrixXd::Zero(6, graph_.rows());
    incidence.middleCols<6>(row_of(pair.source)).setIdentity();
    incidence.middleCols<6>(row_of(pair.target)) -= Matrix6d::Identity();
    return incidence.transpose() * block * incidence;
  }

  Graph& graph_;
  std::vector<Eigen::Index> free_;
};

Eigen::VectorXd stacked(const std::vector<RigidTangent>& tangents) {
  Eigen::VectorXd all(static_cast<Eigen::Index>(6 * tangents.size()));
  for (std::size_t i = 0; i < tangents.size(); ++i) all.segment<6>(row_of(i)) = tangents[i];
  return all;
}

std::optional<PoseCovariance> covariance_of(Graph& graph) {
  const PoseGraphSystem system = graph.system();
  return system.covariance(graph.poses, graph.scores, system.variance_inflation(graph.scores),
                           kGain);
}

Eigen::MatrixXd assembled(const PoseCovariance& covariance, std::size_t views) {
  Eigen::MatrixXd all(6 * views, 6 * views);
  for (std::size_t a = 0; a < views; ++a)
    for (std::size_t b = 0; b < views; ++b)
      all.block<6, 6>(row_of(a), row_of(b)) = covariance.between(a, b);
  return all;
}

// Each component relative to its own size: radians and units differ by orders of magnitude.
void expect_like_reference(Graph& graph, double tolerance = 1e-8) {
  const DenseReference reference(graph);
  const PoseGraphStep step = graph.system().step();
  ASSERT_TRUE(step.usable()) << step.summary.message;
  const Eigen::VectorXd expected = reference.step();
  EXPECT_LT((stacked(step.tangents) - expected).norm(), tolerance * expected.norm() + 1e-300);
  const auto covariance = covariance_of(graph);
  ASSERT_TRUE(covariance.has_value());
  const Eigen::MatrixXd found = assembled(*covariance, graph.poses.size());
  const Eigen::MatrixXd dense = reference.covariance();
  const Eigen::VectorXd deviation = dense.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < dense.rows(); ++i)
    for (Eigen::Index j = 0; j < dense.cols(); ++j)
      EXPECT_LE(std::abs(found(i, j) - dense(i, j)), tolerance * deviation[i] * deviation[j])
          << i << ' ' << j;
  for (std::size_t i = 0; i < graph.poses.size(); ++i)
    EXPECT_TRUE(covariance->of(i) == covariance->of(i).transpose());
}

const Links kRing = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}};

TEST(PoseGraphSystem, SolvesLikeDenseMatrices) {
  Graph graph(4, kRing, {true, false, false, false});
  expect_like_reference(graph);
}

// So many that blocks of single views alone are known.
TEST(PoseGraphSystem, HasCovariancesOfManyViewsLikeDenseMatrices) {
  Links links;
  for (std::size_t i = 0; i < 40; ++i) {
    links.emplace_back(i, (i + 1) % 40);
    links.emplace_back(i, (i + 7) % 40);
  }
  std::vector<bool> held(40, false);
  held[5] = true;
  Graph graph(40, links, held);
  const auto covariance = covariance_of(graph);
  ASSERT_TRUE(covariance.has_value());
  const Eigen::MatrixXd dense = DenseReference(graph).covariance();
  for (std::size_t i = 0; i < 40; ++i) {
    const Matrix6d expected = dense.block<6, 6>(row_of(i), row_of(i));
    const Matrix6d difference = covariance->of(i) - expected;
    const Vector6d deviation = expected.diagonal().cwiseSqrt();
    for (Eigen::Index k = 0; k < 6; ++k)
      for (Eigen::Index l = 0; l < 6; ++l)
        EXPECT_LE(std::abs(difference(k, l)), 1e-8 * deviation[k] * deviation[l]) << i;
  }
}

TEST(PoseGraphSystem, SolvesTwoGroups) {
  Graph graph(5, {{0, 1}, {2, 3}, {3, 4}}, {true, false, false, true, false});
  expect_like_reference(graph);
}

TEST(PoseGraphSystem, SolvesForOneFreeView) {
  Graph graph(3, {{0, 1}, {1, 2}, {2, 0}}, {true, true, false});
  expect_like_reference(graph);
  EXPECT_EQ(graph.system().step().summary.stage, SolverStage::kPoseGraph);
}

TEST(PoseGraphSystem, LeavesHeldViewsAlone) {
  Graph graph(3, {{0, 1}, {1, 2}}, {true, true, true});
  const PoseGraphStep step = graph.system().step();
  EXPECT_TRUE(step.usable()) << step.summary.message;
  EXPECT_TRUE(stacked(step.tangents).isZero(0.0));
  const auto covariance = covariance_of(graph);
  ASSERT_TRUE(covariance.has_value());
  EXPECT_TRUE(assembled(*covariance, 3).isZero(0.0));
}

TEST(PoseGraphSystem, KnowsOfAViewThatNoPairHoldsWhatThePriorSays) {
  Graph graph(4, {{0, 1}, {1, 2}}, {true, false, false, false});
  expect_like_reference(graph);
  EXPECT_TRUE(graph.system().step().tangents[3].isZero(0.0));
  const auto covariance = covariance_of(graph);
  ASSERT_TRUE(covariance.has_value());
  const Eigen::Matrix3d of_turns = covariance->of(3).topLeftCorner<3, 3>();
  EXPECT_TRUE(of_turns.isApprox(Eigen::Matrix3d::Identity(), 1e-9));
}

// Without a held view the prior alone holds the whole: a billionth of what the pairs know.
TEST(PoseGraphSystem, SolvesWithoutHeldViews) {
  Graph graph(4, kRing, {false, false, false, false});
  expect_like_reference(graph, 1e-4);
}

TEST(PoseGraphSystem, SolvesPairsThatLeaveMotionsUndetermined) {
  Graph graph(3, {}, {true, false, false});
  graph.add(0, 1, 4);
  graph.add(1, 2, 3);
  graph.add(2, 0, 4);
  expect_like_reference(graph, 1e-6);

  Graph chain(3, {}, {true, false, false});
  chain.add(0, 1, 40);
  chain.add(2, 1, 4);
  expect_like_reference(chain, 1e-4);
}

TEST(PoseGraphSystem, DoesNotSolveWhatIsNotFinite) {
  Graph graph(2, {{0, 1}}, {true, false});
  graph.pairs[0].score[2] = std::numeric_limits<double>::quiet_NaN();
  const PoseGraphStep step = graph.system().step();
  EXPECT_FALSE(step.usable());
  EXPECT_FALSE(step.summary.message.empty());
  EXPECT_FALSE(covariance_of(graph).has_value());
}

// The cost after the step is what least squares over the same residuals leaves.
TEST(PoseGraphSystem, TellsWhatTheStepCostsBeforeAndAfter) {
  Graph graph(3, {{0, 1}, {1, 2}, {2, 0}}, {true, false, false});
  const PoseGraphStep step = graph.system().step();
  double before = 0.0, gain = 0.0;
  for (const auto& pair : graph.pairs) {
    before += 0.5 * pair.losses;
    const RigidTangent x = step.tangents[pair.source] - step.tangents[pair.target];
    gain -= x.dot(pair.score + 0.5 * pair.information * x);
  }
  EXPECT_GT(gain, 0.0);
  EXPECT_NEAR(step.summary.initial_cost, before, 1e-9 * before);
  EXPECT_NEAR(step.summary.final_cost, before - gain, 1e-6 * before);
  EXPECT_EQ(step.summary.termination, SolverTermination::kConverged) << step.summary.message;
  EXPECT_GE(step.summary.iterations, 1);
}

}  // namespace
}  // namespace relief::registration
