// The parts of the multigrid solver against dense matrices.
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "hybrid/model/view_system.h"
#include "hybrid/multigrid/aggregation.h"
#include "hybrid/multigrid/edge_stencil.h"
#include "hybrid/multigrid/galerkin.h"
#include "hybrid/multigrid/multigrid.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

constexpr double kDamping = 0.6;

// A view with holes and an occlusion along column 7, in the middle of a block.
RangeView ragged_view() {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(20, 17));
  testing::add_range_noise(view, 0.2, 1);
  testing::add_normal_noise(view, 0.05, 2);
  std::mt19937 generator(3);
  for (double& t : view.range)
    if (generator() % 7 == 0) t = kNoSample;
  for (int v = 0; v < 17; ++v)
    for (int u = 7; u < 20; ++u) view.range(u, v) += 40.0;
  return view;
}

class Coarsening : public ::testing::Test {
 protected:
  Coarsening()
      : view_(ragged_view()),
        problem_(make_view_problem(view_, connect_samples(view_), Stencil::kCompactEdge)),
        stencil_(problem_, true) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> uniform(0.5f, 2.0f);
    weights_.bias_size = 0.1f;
    for (auto* plane :
         {&weights_.position, &weights_.slope[0], &weights_.slope[1], &weights_.bias_step})
      plane->assign(problem_.grid.size(), 0.0f);
    for (const std::uint32_t i : problem_.pixels) {
      weights_.position[i] = 0.05f * uniform(generator);
      weights_.bias_step[i] = 1.7f * uniform(generator);
    }
    problem_.slopes.for_each([&](int axis, std::size_t i) {
      weights_.slope[static_cast<std::size_t>(axis)][i] = uniform(generator);
    });
    stencil_.set_weights(weights_);
  }

  Eigen::Index count() const { return static_cast<Eigen::Index>(problem_.size()); }
  Eigen::MatrixXd dense_matrix() const {
    ViewSystem system(problem_, true);
    system.assemble(weights_);
    return Eigen::MatrixXd(system.lower()).selfadjointView<Eigen::Lower>();
  }

  template <typename T>
  Planes<T> planes_of(const Eigen::VectorXd& values) const {
    Planes<T> planes(problem_.grid.size());
    for (Eigen::Index k = 0; k < count(); ++k) {
      const std::uint32_t i = problem_.pixels[static_cast<std::size_t>(k)];
      planes.x[i] = static_cast<T>(values[k]);
      planes.bu[i] = static_cast<T>(values[count() + k]);
      planes.bv[i] = static_cast<T>(values[2 * count() + k]);
    }
    return planes;
  }
  template <typename T>
  Eigen::VectorXd vector_of(const Planes<T>& planes) const {
    Eigen::VectorXd values(3 * count());
    for (Eigen::Index k = 0; k < count(); ++k) {
      const std::uint32_t i = problem_.pixels[static_cast<std::size_t>(k)];
      values[k] = planes.x[i];
      values[count() + k] = planes.bu[i];
      values[2 * count() + k] = planes.bv[i];
    }
    return values;
  }
  Eigen::VectorXd random_vector(unsigned seed) const {
    std::srand(seed);
    return Eigen::VectorXd::Random(3 * count());
  }

  RangeView view_;
  ViewProblem problem_;
  EdgeStencil stencil_;
  ViewWeights weights_;
};

// The inverse of the 3 x 3 blocks on the diagonal, unknowns of a node `stride` apart.
Eigen::MatrixXd inverse_blocks(const Eigen::MatrixXd& matrix, Eigen::Index nodes,
                               Eigen::Index node_step, Eigen::Index unknown_step) {
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  for (Eigen::Index k = 0; k < nodes; ++k) {
    Eigen::Matrix3d block;
    const auto at = [&](Eigen::Index a) { return k * node_step + a * unknown_step; };
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) block(r, c) = matrix(at(r), at(c));
    const Eigen::Matrix3d inverted = block.inverse();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) inverse(at(r), at(c)) = inverted(r, c);
  }
  return inverse;
}

Eigen::Matrix3d matrix_of(const Transport& motion) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix.row(0) << motion.scale, motion.along_u, motion.along_v;
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix) {
  const auto size = static_cast<Eigen::Index>(3 * matrix.rows());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < matrix.rows(); ++i)
    matrix.for_each_block(i, [&](std::uint32_t j, const auto& block) {
      result.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) =
          block;
    });
  return result;
}

Eigen::MatrixXd galerkin(const Eigen::MatrixXd& a, const Eigen::MatrixXd& inverse,
                         const Eigen::MatrixXd& rigid) {
  const Eigen::MatrixXd p = rigid - kDamping * inverse * (a * rigid);
  return p.transpose() * a * p;
}

TEST_F(Coarsening, TheStencilIsTheMatrixOfTheView) {
  const Eigen::VectorXd x = random_vector(1).cast<float>().cast<double>();
  const Eigen::VectorXd r = random_vector(2), before = random_vector(3);
  const Eigen::MatrixXd a = dense_matrix();
  const Eigen::MatrixXd inverse = inverse_blocks(a, count(), 1, count());
  const StencilView s = stencil_.view();
  const Planes<float> single = planes_of<float>(x), rhs = planes_of<float>(r);
  Planes<double> rest = planes_of<double>(before);
  Planes<float> rounded = rhs, residual = rhs, relaxed = planes_of<float>(before), scaled = rhs;
  double energy = 0.0, product = 0.0;
  for (const RowSpan& span : stencil_.spans()) {
    energy += energy_row(s, single.view(), span.begin, span.end);
    product += dot_row(std::as_const(rest).view(), single.view(), span.begin, span.end);
    subtract_row(s, 0.5, single.view(), span.begin, span.end, rest.view(), rounded.view());
    residual_row(s, rhs.view(), -0.5f, single.view(), span.begin, span.end, residual.view());
    relax_row(s, 0.25f, 2.0f, single.view(), 0.75f, rhs.view(), span.begin, span.end,
              relaxed.view());
    scale_row(s, 3.0f, rhs.view(), span.begin, span.end, scaled.view());
  }
  EXPECT_NEAR(energy, x.dot(a * x), 1e-12 * energy);
  EXPECT_NEAR(product, before.dot(x), 1e-12 * before.norm() * x.norm());
  const Eigen::VectorXd expected_rest = before - 0.5 * (a * x);
  EXPECT_LT((vector_of(rest) - expected_rest).norm(), 1e-12 * expected_rest.norm());
  EXPECT_LT((vector_of(rounded) - expected_rest).norm(), 1e-6 * expected_rest.norm());
  const Eigen::VectorXd expected_residual = r - 0.5 * (a * x);
  EXPECT_LT((vector_of(residual) - expected_residual).norm(), 1e-6 * expected_residual.norm());
  const Eigen::VectorXd expected = 0.25 * before + 2.0 * x + 0.75 * (inverse * (r - a * x));
  EXPECT_LT((vector_of(relaxed) - expected).norm(), 1e-5 * expected.norm());
  EXPECT_LT((vector_of(scaled) - 3.0 * (inverse * r)).norm(), 1e-5 * (inverse * r).norm());
}

TEST_F(Coarsening, GroupsLieInBlocksAndSpanNoOcclusion) {
  const Aggregates groups = aggregate_pixels(stencil_);
  std::map<std::uint32_t, std::set<bool>> sides;
  for (const std::uint32_t i : problem_.pixels) {
    const int u = problem_.grid.u(i), v = problem_.grid.v(i);
    ASSERT_NE(groups.label[i], kNoAggregate);
    const Aggregates::Node& node = groups.nodes[groups.label[i]];
    EXPECT_EQ(node.column, u / 3);
    EXPECT_EQ(node.row, v / 3);
    sides[groups.label[i]].insert(u < 7);
  }
  for (const auto& [group, side] : sides) EXPECT_EQ(side.size(), 1u) << group;
  EXPECT_EQ(groups.rows.back(), groups.nodes.size());
}

TEST_F(Coarsening, RigidMotionsFollowTheConstraintsFromTheRoot) {
  // In a line of samples, no constraint closes a loop: all within a group hold exactly.
  RangeView line = view_;
  for (int v = 0; v < 17; ++v)
    for (int u = 0; u < 20; ++u)
      if (v % 3 != 1) line.range(u, v) = kNoSample;
  const ViewProblem problem = make_view_problem(line, connect_samples(line), Stencil::kCompactEdge);
  EdgeStencil stencil(problem, true);
  ViewWeights ones;
  ones.position.assign(problem.grid.size(), 1.0f);
  ones.slope = {ones.position, ones.position};
  ones.bias_step = ones.position;
  ones.bias_size = 1.0f;
  for (const std::size_t axis : {0, 1})
    for (std::size_t i = 0; i < problem.grid.size(); ++i)
      if (!problem.slopes.exists(static_cast<int>(axis), i)) ones.slope[axis][i] = 0.0f;
  stencil.set_weights(ones);
  const Aggregates groups = aggregate_pixels(stencil);
  int checked = 0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = problem.slopes.ends(axis, i);
    if (groups.label[ends.tail] != groups.label[ends.head]) return;
    const auto& a = problem.slopes.axes[static_cast<std::size_t>(axis)];
    const Transport& tail = groups.from_root[ends.tail];
    const Transport& head = groups.from_root[ends.head];
    EXPECT_NEAR(a.head_slope[i] * head.scale, a.tail_slope[i] * tail.scale, 1e-6);
    EXPECT_NEAR(a.head_slope[i] * head.along_u - a.tail_slope[i] * tail.along_u,
                2.0 * a.half_length[i], 1e-5);
    ++checked;
  });
  EXPECT_GT(checked, 20);
}

TEST_F(Coarsening, CoarseMatricesAreGalerkinProducts) {
  const Aggregates groups = aggregate_pixels(stencil_);
  const CoarseMatrix coarse = coarsen(stencil_, groups, kDamping);
  Eigen::MatrixXd rigid =
      Eigen::MatrixXd::Zero(3 * count(), static_cast<Eigen::Index>(3 * groups.nodes.size()));
  for (Eigen::Index k = 0; k < count(); ++k) {
    const std::uint32_t i = problem_.pixels[static_cast<std::size_t>(k)];
    const Eigen::Matrix3d motion = matrix_of(groups.from_root[i]);
    for (int unknown = 0; unknown < 3; ++unknown)
      rigid.block<1, 3>(unknown * count() + k, 3 * static_cast<Eigen::Index>(groups.label[i])) =
          motion.row(unknown);
  }
  const Eigen::MatrixXd a = dense_matrix();
  const Eigen::MatrixXd expected = galerkin(a, inverse_blocks(a, count(), 1, count()), rigid);
  const Eigen::MatrixXd found = dense(coarse.matrix);
  EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());

  const Aggregates next = aggregate_nodes(groups);
  const CoarseMatrix coarser = coarsen(coarse, groups.rows, next, kDamping);
  const auto nodes = static_cast<Eigen::Index>(groups.nodes.size());
  Eigen::MatrixXd rigid_nodes =
      Eigen::MatrixXd::Zero(3 * nodes, static_cast<Eigen::Index>(3 * next.nodes.size()));
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const std::uint32_t label = next.label[static_cast<std::size_t>(i)];
    if (label != kNoAggregate)
      rigid_nodes.block<3, 3>(3 * i, 3 * static_cast<Eigen::Index>(label)) =
          matrix_of(next.from_root[static_cast<std::size_t>(i)]);
  }
  const Eigen::MatrixXd expected_next =
      galerkin(found, inverse_blocks(found, nodes, 3, 1), rigid_nodes);
  EXPECT_LT((dense(coarser.matrix) - expected_next).norm(), 1e-9 * expected_next.norm());
}

TEST_F(Coarsening, TheCycleIsSymmetricAndPositive) {
  Multigrid multigrid(stencil_);
  ASSERT_TRUE(multigrid.usable());
  const auto applied = [&](const Eigen::VectorXd& r) {
    Planes<float> x(problem_.grid.size());
    multigrid.apply(planes_of<float>(r), x);
    return vector_of(x);
  };
  for (unsigned seed = 1; seed < 5; ++seed) {
    const Eigen::VectorXd a = random_vector(seed), b = random_vector(seed + 10);
    const Eigen::VectorXd image_of_a = applied(a), image_of_b = applied(b);
    EXPECT_NEAR(a.dot(image_of_b), b.dot(image_of_a), 1e-4 * a.norm() * image_of_b.norm());
    EXPECT_GT(a.dot(image_of_a), 0.0);
  }
}

}  // namespace
}  // namespace relief::hybrid
