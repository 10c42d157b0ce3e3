#include "hybrid/mesh/mesh_preconditioner.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "hybrid/mesh/mesh_aggregates.h"
#include "relief/scan/context.h"
#include "tests/hybrid/mesh_shapes.h"

namespace relief::hybrid {
namespace {

// Edges of irregular weights, and vertices that are held weakly: moves die out over some 30 edges.
MeshMatrix irregular_matrix(const MeshGraph& graph) {
  MeshMatrix matrix;
  matrix.graph = &graph;
  matrix.diagonal = MeshValues(graph.vertices());
  matrix.off_diagonal = PagedArray<float>(graph.neighbour.size());
  for (std::size_t i = 0; i < graph.vertices(); ++i) {
    matrix.diagonal[i] = 1e-3;
    for (std::size_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k) {
      const std::size_t both = i + graph.neighbour[k];
      const double weight = 1.0 + 0.9 * std::sin(static_cast<double>(both));
      matrix.diagonal[i] += weight;
      matrix.off_diagonal[k] = static_cast<float>(-weight);
    }
  }
  return matrix;
}

MeshValues random_values(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  MeshValues values(count);
  for (double& value : values) value = uniform(random);
  return values;
}

double dot(const MeshValues& a, const MeshValues& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

double distance(const MeshValues& a, const MeshValues& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

class MeshPreconditionerTest : public ::testing::Test {
 protected:
  MeshGraph graph = mesh_graph(testing::plane_mesh(250));
  MeshMatrix matrix = irregular_matrix(graph);
};

TEST_F(MeshPreconditionerTest, AggregatesHangTogetherAndHoldEachVertexOnce) {
  const MeshAggregates aggregates(graph);
  std::size_t members = 0, largest = 0;
  for (std::size_t a = 0; a < aggregates.size(); ++a) {
    members += aggregates.members(a).size();
    largest = std::max(largest, aggregates.members(a).size());
    for (const std::uint32_t v : aggregates.members(a)) EXPECT_EQ(aggregates.of(v), a);
  }
  EXPECT_EQ(members, graph.vertices());
  EXPECT_LT(aggregates.size(), graph.vertices() / 30);
  EXPECT_LT(largest, 200u);
}

// P^T A P x, by its definition.
TEST_F(MeshPreconditionerTest, TheMatrixOfAggregatesIsTheProduct) {
  const MeshAggregates aggregates(graph);
  const AggregateMatrix coarse(matrix, aggregates);
  const MeshValues x = random_values(aggregates.size(), 1);
  MeshValues carried(graph.vertices()), expected(aggregates.size());
  for (std::size_t i = 0; i < carried.size(); ++i) carried[i] = x[aggregates.of(i)];
  const MeshValues product = matrix * carried;
  for (std::size_t i = 0; i < product.size(); ++i) expected[aggregates.of(i)] += product[i];
  // Entries off the diagonal are in single precision.
  EXPECT_LT(distance(coarse.matrix * x, expected), 1e-6 * std::sqrt(dot(expected, expected)));
  for (std::size_t a = 0; a < coarse.graph.vertices(); ++a)
    for (std::size_t k = coarse.graph.begin[a] + 1; k < coarse.graph.begin[a + 1]; ++k)
      EXPECT_LT(coarse.graph.neighbour[k - 1], coarse.graph.neighbour[k]);
}

// Levels of 63,001, about 1,400 and 30 unknowns in place of two.
TEST_F(MeshPreconditionerTest, AggregatesOfAggregatesGiveWhatAFactorisationGives) {
  MeshPreconditioner factorised(matrix), iterated(matrix, 100);
  ASSERT_TRUE(factorised.update());
  ASSERT_TRUE(iterated.update());
  const MeshValues x = random_values(graph.vertices(), 2), y = random_values(graph.vertices(), 3);
  const MeshValues expected = factorised(x), found = iterated(x);
  EXPECT_LT(distance(found, expected), 0.01 * std::sqrt(dot(expected, expected)));
  EXPECT_NEAR(dot(found, y), dot(x, iterated(y)), 0.01 * std::sqrt(dot(found, found) * dot(y, y)));

  const auto steps = [&](const MeshPreconditioner& inverse) {
    MeshValues solution(graph.vertices());
    const ConjugateGradients solve = conjugate_gradients(
        [&](const MeshValues& v) { return matrix * v; },
        [&](const MeshValues& r) { return inverse(r); }, x, 1e-6, 500, solution);
    EXPECT_TRUE(solve.converged);
    EXPECT_LT(distance(matrix * solution, x), 1e-4 * std::sqrt(dot(x, x)));
    return solve.iterations;
  };
  EXPECT_LE(steps(iterated), steps(factorised) + 1);
}

TEST_F(MeshPreconditionerTest, IteratedIsTheSameOnAnyNumberOfThreads) {
  const MeshValues x = random_values(graph.vertices(), 4);
  const auto with_threads = [&](int threads) {
    Context context;
    context.threads = threads;
    MeshValues result;
    const auto ok = run_in(context, [&]() -> Result<void> {
      MeshPreconditioner inverse(matrix, 100);
      EXPECT_TRUE(inverse.update());
      result = inverse(x);
      return {};
    });
    EXPECT_TRUE(ok);
    return result;
  };
  const MeshValues one = with_threads(1), three = with_threads(3);
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i], three[i]);
}

TEST_F(MeshPreconditionerTest, SaysThatAMatrixIsNotPositiveDefinite) {
  for (double& value : matrix.diagonal) value = -value;
  EXPECT_FALSE(MeshPreconditioner(matrix).update());
  EXPECT_FALSE(MeshPreconditioner(matrix, 100).update());
}

}  // namespace
}  // namespace relief::hybrid
