#include "apps/stages/alignment_gain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

Json view(const std::string& name, bool aligned, double deviation) {
  return {{"name", name},
          {"aligned", aligned},
          {"world_from_view", to_json(RigidMotion::Identity())},
          {"pose_std", {0.0, 0.0, 0.0, deviation, 0.0, 0.0}}};
}

Json section(double rms, const std::vector<Json>& views) {
  return {{"rms", rms}, {"views", views}};
}

const Json kFirst = section(0.2, {view("a", true, 0.0), view("b", true, 0.04)});

TEST(AlignmentGain, IsKeptWhereDeviationsFall) {
  const Json again = section(0.1, {view("a", true, 0.0), view("b", true, 0.03)});
  const Json gain = alignment_gain(kFirst, again, {});
  EXPECT_TRUE(gain["kept"]);
  EXPECT_EQ(gain["pose_std"]["first"], 0.04);
  EXPECT_EQ(gain["pose_std"]["again"], 0.03);
  EXPECT_EQ(gain["rms"]["again"], 0.1);
}

TEST(AlignmentGain, IsDroppedWhereDeviationsGrow) {
  const Json again = section(0.1, {view("a", true, 0.0), view("b", true, 0.05)});
  const Json gain = alignment_gain(kFirst, again, {});
  EXPECT_FALSE(gain["kept"]);
  EXPECT_THAT(gain_table(gain, "mm"), Contains(HasSubstr("no gain expected")));
}

TEST(AlignmentGain, IsDroppedWhereTheSolverFailed) {
  Json again = section(0.1, {view("a", true, 0.0), view("b", true, 0.0)});
  again["termination"] = "solver failed";
  EXPECT_FALSE(alignment_gain(kFirst, again, {})["kept"]);
}

TEST(AlignmentGain, IsDroppedWhereAViewNoLongerFits) {
  const Json again = section(0.1, {view("a", true, 0.01), view("b", false, 0.0)});
  const Json gain = alignment_gain(kFirst, again, {});
  EXPECT_EQ(gain["left_out"], 1);
  EXPECT_FALSE(gain["kept"]);
  EXPECT_THAT(gain_table(gain, "mm"), Contains(HasSubstr("1 of the views no longer fit")));
}

}  // namespace
}  // namespace relief
