#include "scan/surface/packed_normals.h"

#include <limits>

#include <gtest/gtest.h>

namespace relief {
namespace {

TEST(PackedNormals, KeepNormalsToTheirPrecisionWhereTheyAre) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Grid<Eigen::Vector3f> normals(7, 6, Eigen::Vector3f::Constant(nan));
  EXPECT_FALSE(PackedNormals(normals).holds(3, 3, 3, 3));
  normals(2, 1) = Eigen::Vector3f(0.6f, 0.0f, -0.8f);
  normals(4, 3) = Eigen::Vector3f(1.0f, -2.0f, -3.0f).normalized();
  const PackedNormals packed(normals);
  EXPECT_TRUE(packed.holds(2, 1, 4, 3));
  EXPECT_FALSE(packed.holds(1, 1, 4, 3));
  EXPECT_FALSE(packed.holds(2, 1, 5, 3));
  EXPECT_FALSE(packed.holds(2, 0, 4, 3));
  EXPECT_FALSE(packed.holds(2, 1, 4, 4));
  for (int v = 1; v <= 3; ++v) {
    for (int u = 2; u <= 4; ++u) {
      ASSERT_EQ(packed(u, v).exists(), normals(u, v).allFinite());
      if (!packed(u, v).exists()) continue;
      const Eigen::Vector3d unit = packed(u, v).scaled() / PackedNormal::kUnit;
      EXPECT_LT((unit - normals(u, v).cast<double>()).norm(), 3e-5);
    }
  }
}

}  // namespace
}  // namespace relief
