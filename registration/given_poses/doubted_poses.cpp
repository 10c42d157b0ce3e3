#include "registration/given_poses/doubted_poses.h"

#include <algorithm>
#include <cstddef>
#include <iomanip>
#include <sstream>
#include <string>
#include <utility>

#include "registration/given_poses/given_pose_notes.h"
#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

constexpr std::size_t kAllMotions = 6;

bool can_be_doubted(const RangeView& view, const ViewReport& report) {
  return report.status == PoseStatus::kVerified && view.pose != PoseKind::kKnown;
}

void doubt(ViewReport& view, std::string reason) {
  view.status = PoseStatus::kUnverified;
  view.reason = std::move(reason);
}

}  // namespace

void doubt_unsettled_poses(const std::vector<RangeView>& views, Alignment& alignment) {
  const double deviation = median_deviation(alignment);
  if (alignment.termination != RefinementTermination::kIterationLimit || deviation == 0.0 ||
      !(alignment.last_motion > std::max(deviation, alignment.spacing)))
    return;
  std::ostringstream reason;
  reason << std::setprecision(2) << "refining did not settle: its last step still moved views by "
         << alignment.last_motion / alignment.spacing << " sample spacings, "
         << alignment.last_motion / deviation
         << " times what poses would err by; check the given poses, the focal length and the depth "
            "scale, and whether something moved";
  for (std::size_t i = 0; i < views.size(); ++i)
    if (can_be_doubted(views[i], alignment.views[i])) doubt(alignment.views[i], reason.str());
}

void doubt_undetermined_poses(const std::vector<RangeView>& views, Alignment& alignment) {
  if (views.size() < 2) return;
  std::vector<bool> has_pair(views.size(), false);
  for (const PairFit& pair : alignment.pairs) has_pair[pair.a] = has_pair[pair.b] = true;
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewReport& view = alignment.views[i];
    if (!can_be_doubted(views[i], view)) continue;
    if (!has_pair[i])
      doubt(view,
            "it fits where it stands, but shares too few samples with other views to refine its "
            "pose");
    else if (view.kept_motions.size() == kAllMotions)
      doubt(view,
            "it fits where it stands, but the relief that it shares with other views determines "
            "none of its motions");
  }
}

void doubt_kept_motions(const std::vector<RangeView>& views,
                        const std::vector<ViewSurface>& surfaces, const PoseConvention& convention,
                        Alignment& alignment) {
  const auto given = given_and_found(views, surfaces, convention, alignment,
                                     std::vector<bool>(views.size(), true));
  const double typical = median_move(given);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewReport& view = alignment.views[i];
    if (view.kept_motions.empty() || !can_be_doubted(views[i], view)) continue;
    const auto moved = std::ranges::find(given, view.name, &GivenAndFound::name);
    if (moved == given.end()) continue;
    const bool itself = !(typical > alignment.spacing);
    const double move = itself ? move_of(*moved) : typical;
    if (!(move > alignment.spacing)) continue;
    std::ostringstream reason;
    reason << std::setprecision(2)
           << "nothing that it shares with other views tells how far its guess is off along one "
              "motion ("
           << view.kept_motions.front().description << "), and where they tell, "
           << (itself ? "it was off by " : "guesses were off by ") << move
           << (itself ? "" : " (median)");
    doubt(view, reason.str());
  }
}

void doubt_what_shape_does_not_confirm(const std::vector<ViewSurface>& surfaces,
                                       const Alignment& found, Alignment& alignment) {
  const auto is_confirmed = [&](std::size_t i, std::size_t j) {
    if (i == j || found.views[i].status != PoseStatus::kVerified ||
        found.views[j].status != PoseStatus::kVerified)
      return false;
    const RigidMotion by_shape =
        found.views[j].world_from_view.inverse() * found.views[i].world_from_view;
    const RigidMotion refined =
        alignment.views[j].world_from_view.inverse() * alignment.views[i].world_from_view;
    return largest_motion(by_shape.inverse() * refined, surfaces[i]) <=
           coarser_spacing(surfaces[i], surfaces[j]);
  };
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    ViewReport& view = alignment.views[i];
    bool confirmed = view.status != PoseStatus::kVerified;
    for (std::size_t j = 0; j < surfaces.size() && !confirmed; ++j) confirmed = is_confirmed(i, j);
    if (!confirmed)
      doubt(view,
            "refining moved the views far from their given poses, to where they deviate by more "
            "than their noise, and their shape does not confirm it; check the given poses");
  }
}

double median_deviation(const Alignment& alignment) {
  std::vector<double> deviations;
  for (const ViewReport& view : alignment.views)
    if (view.aligned && !view.pose_std.isZero(0.0))
      deviations.push_back(view.pose_std.tail<3>().norm());
  return deviations.empty() ? 0.0 : quantile(std::move(deviations), 0.5);
}

}  // namespace relief::registration
