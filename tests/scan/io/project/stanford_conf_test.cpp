#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/project/view_spec.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

TEST(StanfordConf, TheQuaternionIsTheInverseRotation) {
  // The usual quaternion (0, 0, s, s) turns x into y; in this format it turns y into x.
  const auto spec = value_of(parse_stanford_conf(
      "camera 0 0 0 0 0 0 1\n\nbmesh a.ply 1 2 3 0 0 0.70710678 0.70710678\n", "d/bun.conf"));
  const ViewSpec& view = spec.views.at(0);
  EXPECT_EQ(view.name, "a");
  EXPECT_EQ(*view.grid, "d/a.ply");
  EXPECT_EQ(view.pose, PoseKind::kGuess);
  const Eigen::Vector3d moved = view.world_from_view * Eigen::Vector3d(0, 1, 0);
  EXPECT_NEAR((moved - Eigen::Vector3d(2, 2, 3)).norm(), 0.0, 1e-7);
}

TEST(StanfordConf, NamesOfFilesMayHoldBlanks) {
  const auto spec = value_of(parse_stanford_conf(
      "bmesh dragon 0.5 left.ply 1 2 3 0 0 0 1\nbmesh scan 1 2 3 0 0 0 1\n", "d/bun.conf"));
  EXPECT_EQ(*spec.views.at(0).grid, "d/dragon 0.5 left.ply");
  EXPECT_EQ(spec.views[0].name, "dragon 0.5 left");
  EXPECT_EQ(*spec.views.at(1).grid, "d/scan");
}

TEST(StanfordConf, ErrorsNameTheLine) {
  const auto error = [](const std::string& text) { return parse_stanford_conf(text, "bun.conf"); };
  EXPECT_THAT(error("camera 0\nbmesh a.ply 1 2\n"), HasError("bun.conf: line 2"));
  EXPECT_THAT(error("bmesh a.ply 1 2 3 0 0 0 2\n"), HasError("length 2"));
  EXPECT_THAT(error("bmesh a.ply 1 2 3 0 0 0 1 9\n"), HasError("unexpected '9'"));
  EXPECT_THAT(error("amesh a.ply\n"), HasError("'amesh'"));
  EXPECT_THAT(error("bmesh a.ply 0 0 0 0 0 0 1\nbmesh b/a.ply 0 0 0 0 0 0 1\n"),
              HasError("second scan"));
  EXPECT_THAT(error("camera 0\n"), HasError("no bmesh"));
}

}  // namespace
}  // namespace relief
