#include <gtest/gtest.h>

#include "relief/registration/align_views.h"

namespace relief::registration {
namespace {

ViewReport report_at(double x, bool aligned) {
  ViewReport report;
  report.world_from_view = RigidMotion(Eigen::Translation3d(x, 0, 0));
  report.aligned = aligned;
  return report;
}

TEST(ApplyAlignment, GivesAlignedViewsTheirPoseAndItsKind) {
  std::vector<RangeView> views(6);
  views[1].pose = PoseKind::kGuess;
  views[2].pose = PoseKind::kKnown;
  Alignment alignment;
  for (const double x : {1.0, 2.0, 3.0}) alignment.views.push_back(report_at(x, true));
  for (const double x : {4.0, 5.0, 6.0}) alignment.views.push_back(report_at(x, false));
  views[4].pose = PoseKind::kGuess;  // Of another frame, or refuted: merging must not take it.
  views[5].pose = PoseKind::kKnown;
  apply_alignment(alignment, views);

  const PoseKind kinds[] = {PoseKind::kGuess,  PoseKind::kGuess,  PoseKind::kKnown,
                            PoseKind::kAbsent, PoseKind::kAbsent, PoseKind::kKnown};
  const double places[] = {1.0, 2.0, 3.0, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(views[i].pose, kinds[i]) << i;
    EXPECT_EQ(views[i].world_from_view.translation().x(), places[i]) << i;
  }
}

}  // namespace
}  // namespace relief::registration
