#include "registration/global/unplaced_reason.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using ::testing::HasSubstr;

TEST(UnplacedReason, AsksForAGuessOnlyWhereThereIsNone) {
  std::vector<RangeView> views(2);
  views[0].name = "a";
  views[1].name = "b";
  ViewGroups placed = ViewGroups::singles(2);
  placed.ambiguous.push_back({.a = 0, .b = 1, .overlap = 0.8, .second_overlap = 0.7});
  CheckedPoses checked;
  checked.refuted = {true, false};
  const auto reason = [&](std::size_t view) {
    return unplaced_reason(view, placed, checked, views, {}, {});
  };
  EXPECT_THAT(reason(0), HasSubstr("at its given pose: give a better guess"));
  EXPECT_THAT(reason(1), HasSubstr("plain; give a guess in world_from_view"));
}

}  // namespace
}  // namespace relief::registration
