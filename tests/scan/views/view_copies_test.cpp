#include "scan/views/view_copies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using ::testing::ElementsAre;

RangeView ball_view(double away, double fx = 60.0) {
  return testing::render(testing::sphere({0, 0, away}, 2.0),
                         Camera::pinhole(40, 30, {fx, 60, 19.5, 14.5}));
}

TEST(ViewCopies, HaveTheSamplesAndTheCameraOfTheirOriginal) {
  EXPECT_THAT(originals_of({ball_view(9), ball_view(10), ball_view(9), ball_view(9, 61.0)}),
              ElementsAre(0, 1, 0, 3));
}

TEST(ViewCopies, TheOriginalIsTheOneThatTellsMost) {
  std::vector<RangeView> views(4, ball_view(9));
  for (RangeView& view : views) view.pose = PoseKind::kAbsent;
  views[1].colours = Grid<Colour>(40, 30, Colour{7, 8, 9});
  EXPECT_THAT(originals_of(views), ElementsAre(1, 1, 1, 1));
  views[2].pose = PoseKind::kGuess;
  EXPECT_THAT(originals_of(views), ElementsAre(2, 2, 2, 2));
  views[3].pose = PoseKind::kKnown;
  EXPECT_THAT(originals_of(views), ElementsAre(3, 3, 3, 3));
}

TEST(ViewCopies, AViewWithoutSamplesIsNone) {
  RangeView empty = ball_view(9);
  empty.range = Grid<double>(40, 30, kNoSample);
  EXPECT_THAT(originals_of({empty, empty}), ElementsAre(0, 1));
}

}  // namespace
}  // namespace relief
