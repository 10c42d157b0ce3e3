#include "registration/posegraph/refinement/block_sandwich.h"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

// Made-up matrices of a graph of views.
class RandomBlocks {
 public:
  explicit RandomBlocks(std::size_t views) : views_(views) {}

  Eigen::MatrixXd dense(const SymmetricBlocks& blocks) const {
    const auto size = static_cast<Eigen::Index>(6 * views_);
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
    for (const auto& [at, block] : blocks) {
      const auto row = static_cast<Eigen::Index>(6 * at.first);
      const auto column = static_cast<Eigen::Index>(6 * at.second);
      all.block<6, 6>(row, column) = block;
      all.block<6, 6>(column, row) = block.transpose();
    }
    return all;
  }

  // A vector on two views, times itself.
  void add_square(std::size_t a, std::size_t b, double second, SymmetricBlocks& blocks) {
    Vector6d x, y;
    for (double& value : x) value = normal_(generator_);
    for (double& value : y) value = second * normal_(generator_);
    add({a, a}, x * x.transpose(), blocks);
    add({b, b}, y * y.transpose(), blocks);
    add({a, b}, x * y.transpose(), blocks);
  }

  // An edge of a block Laplacian.
  void add_edge(std::size_t a, std::size_t b, SymmetricBlocks& blocks) {
    Eigen::Matrix<double, 6, 12> j;
    for (double& value : j.reshaped()) value = normal_(generator_);
    const Matrix6d block = j * j.transpose();
    add({a, a}, block, blocks);
    add({b, b}, block, blocks);
    add({a, b}, -block, blocks);
  }

  void add_prior(double precision, SymmetricBlocks& blocks) const {
    for (std::size_t i = 0; i < views_; ++i) add({i, i}, precision * Matrix6d::Identity(), blocks);
  }

 private:
  static void add(std::pair<std::size_t, std::size_t> at, const Matrix6d& block,
                  SymmetricBlocks& blocks) {
    blocks.try_emplace(at, Matrix6d::Zero()).first->second += block;
  }

  std::size_t views_;
  std::mt19937 generator_{7};
  std::normal_distribution<double> normal_;
};

// A sheet of 6 x 7 views with two held ones. The scatter has blocks where no pair is.
struct Sheet {
  explicit Sheet(double prior) {
    for (std::size_t i = 0; i < 42; ++i) {
      if (i % 6 < 5) random.add_edge(i, i + 1, a);
      if (i + 6 < 42) random.add_edge(i, i + 6, a);
      if (i + 12 < 42) random.add_square(i, i + 12, 0.5, b);
    }
    random.add_prior(prior, a);
    random.add_prior(1.0, b);
  }
  RandomBlocks random{42};
  SymmetricBlocks a, b;
};

void expect_like_dense(const Sheet& sheet, const std::vector<bool>& left_out, double tolerance) {
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < left_out.size(); ++i)
    for (Eigen::Index k = 0; k < 6 && !left_out[i]; ++k)
      free.push_back(static_cast<Eigen::Index>(6 * i) + k);
  const Eigen::MatrixXd inverse = sheet.random.dense(sheet.a)(free, free).inverse();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(252, 252);
  dense(free, free) = inverse * sheet.random.dense(sheet.b)(free, free) * inverse;
  const auto found = sandwich_diagonal(sheet.a, sheet.b, left_out);
  ASSERT_TRUE(found.has_value());
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    const Matrix6d expected = dense.block<6, 6>(row, row);
    EXPECT_LE(((*found)[i] - expected).norm(), tolerance * expected.norm()) << "view " << i;
  }
}

TEST(BlockSandwich, HasTheDiagonalOfDenseMatrices) {
  const Sheet sheet(1e-3);
  expect_like_dense(sheet, std::vector<bool>(42, false), 1e-9);
  std::vector<bool> left_out(42, false);
  left_out[0] = left_out[20] = true;
  expect_like_dense(sheet, left_out, 1e-9);
}

TEST(BlockSandwich, LeavesOutAllViews) {
  const auto found = sandwich_diagonal(Sheet(1.0).a, Sheet(1.0).b, std::vector<bool>(42, true));
  ASSERT_TRUE(found.has_value());
  for (const Matrix6d& block : *found) EXPECT_TRUE(block.isZero(0.0));
}

TEST(BlockSandwich, DoesNotInvertWhatRoundingHidesOrIsNotFinite) {
  const Sheet sheet(1e-15);  // Nothing else holds the sheet as a whole.
  EXPECT_FALSE(sandwich_diagonal(sheet.a, sheet.b, std::vector<bool>(42, false)).has_value());
  Sheet other(1.0);
  other.a[{3, 3}](2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(sandwich_diagonal(other.a, other.b, std::vector<bool>(42, false)).has_value());
}

}  // namespace
}  // namespace relief::registration
