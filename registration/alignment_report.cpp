#include "registration/alignment_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>
#include <utility>

#include "registration/given_poses/given_pose_notes.h"
#include "registration/pairwise/robust.h"
#include "registration/verification/still_samples.h"
#include "scan/base/name_list.h"

namespace relief::registration {

namespace {

// Of the views in a frame the largest verified group, of those with known views if there are any. A
// known view alone confirms nothing.
std::size_t main_group(const PoseVerification& verified, const std::vector<RangeView>& views,
                       const std::vector<ViewRole>& roles, const std::vector<std::size_t>& frames,
                       std::size_t frame) {
  std::map<std::size_t, std::pair<bool, std::size_t>> weight;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] == ViewRole::kExcluded || frames[i] != frame) continue;
    auto& [known, size] = weight[verified.group[i]];
    known |= views[i].pose == PoseKind::kKnown;
    ++size;
  }
  std::size_t main = roles.size();
  std::pair<bool, std::size_t> most(false, 1);
  for (const auto& [group, w] : weight) {
    const auto weight_of_group = std::pair(w.first && w.second > 1, w.second);
    if (!(weight_of_group > most)) continue;
    main = group;
    most = weight_of_group;
  }
  return main;
}

// Units of scans differ by ten at least: mm, cm, m. Samples so many times as far apart as those of
// a typical view, or as near, are of another unit, unless other views confirm them.
constexpr double kOtherUnit = 9.0;

// Standard deviations of the noise by which ranges of one place differ at most.
constexpr double kAlike = 5.0;

// 0 where no view has samples.
double typical_spacing(const std::vector<ViewSurface>& surfaces) {
  std::vector<double> spacings;
  for (const ViewSurface& surface : surfaces)
    if (!surface.samples().empty()) spacings.push_back(surface.spacing());
  return spacings.empty() ? 0.0 : quantile(std::move(spacings), 0.5);
}

// What the spacing of each view is in that of a typical one.
std::vector<double> relative_spacings(const std::vector<ViewSurface>& surfaces) {
  const double typical = typical_spacing(surfaces);
  std::vector<double> relative;
  for (const ViewSurface& surface : surfaces)
    relative.push_back(typical > 0.0 && !surface.samples().empty() ? surface.spacing() / typical
                                                                   : 1.0);
  return relative;
}

class AlignmentReport {
 public:
  AlignmentReport(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
                  GivenPoses given_poses, const CheckedPoses& checked,
                  const PoseConvention& convention, AlignmentState state)
      : views_(views),
        surfaces_(surfaces),
        given_poses_(given_poses),
        checked_(checked),
        convention_(convention),
        state_(std::move(state)),
        relative_spacings_(relative_spacings(surfaces)) {}

  Alignment make() {
    Alignment result;
    result.notes = state_.starts.notes;
    if (!convention_.as_given())
      result.notes.push_back("the given poses are taken as " + convention_.describe() +
                             ": so they bring the views together, and as world_from_view they do "
                             "not; --poses trust takes them as they are");
    const std::size_t main =
        main_group(state_.verified, views_, state_.roles, state_.starts.frame, state_.frame);
    for (std::size_t i = 0; i < views_.size(); ++i) result.views.push_back(report_of(i, main));
    note_moves(result);
    note_given_poses(result);
    note_kept_poses(result);
    note_kept_motions(result);
    note_one_place(result);
    if (views_.size() == 1) result.notes.push_back("one view only: nothing to align");
    result.pairs = std::move(state_.refined.pairs);
    result.termination = state_.refined.termination;
    result.iterations = state_.refined.iterations;
    result.last_motion = state_.refined.last_motion;
    result.spacing = typical_spacing(surfaces_);
    result.rms = state_.refined.rms;
    result.solves = std::move(state_.refined.solves);
    result.loops = std::move(state_.refined.loops);
    return result;
  }

 private:
  ViewReport report_of(std::size_t i, std::size_t main_group) const {
    const ViewVerification& verified = state_.verified.views[i];
    ViewReport view;
    view.name = views_[i].name;
    view.world_from_view = state_.refined.world_from_view[i];
    view.pose_std = state_.refined.pose_std[i];
    view.pose_covariance = state_.refined.pose_covariance[i];
    view.aligned = state_.starts.frame[i] == state_.frame && !state_.taken_out[i] &&
                   state_.roles[i] != ViewRole::kExcluded && !has_other_unit(i);
    // More may speak against the pose than confirms it: then what only allows the pose keeps it.
    const bool contradicted = verified.violation > verified.support;
    if (!state_.refined.kept_motions.empty()) view.kept_motions = state_.refined.kept_motions[i];
    const bool shared = (state_.verified.group[i] == main_group && !is_guess_along_a_motion(i)) ||
                        (views_[i].pose == PoseKind::kKnown && verified.overlaps);
    const bool confirmed =
        views_.size() == 1 ||
        (shared && !contradicted && !verified.deviates_alone && !verified.deviates_with_group);
    view.status = !view.aligned ? PoseStatus::kLeftOut
                  : confirmed   ? PoseStatus::kVerified
                                : PoseStatus::kUnverified;
    if (view.status == PoseStatus::kUnverified) view.reason = reason_unverified(i);
    if (view.status == PoseStatus::kLeftOut) view.reason = reason_left_out(i);
    return view;
  }

  // Along a motion that nothing determines a pose found by its shape is what the search left: it
  // fits wherever the view is moved so.
  bool is_guess_along_a_motion(std::size_t i) const {
    return state_.starts.found_by_shape[i] && !state_.refined.kept_motions.empty() &&
           !state_.refined.kept_motions[i].empty();
  }

  void note_moves(Alignment& result) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (state_.starts.found_by_shape[i] && state_.starts.frame[i] == state_.frame &&
          (checked_.refuted[i] || checked_.world_from_view[i]))
        result.notes.push_back(
            "view " + views_[i].name + ": its given pose " +
            (checked_.refuted[i] ? "stands where other views saw through" : "is not confirmed") +
            "; a pose that fits was found by its shape instead");
  }

  void note_given_poses(Alignment& result) const {
    if (given_poses_ == GivenPoses::kIgnore) return;
    std::vector<bool> refined;
    for (std::size_t i = 0; i < views_.size(); ++i)
      refined.push_back(checked_.world_from_view[i] && !state_.starts.found_by_shape[i]);
    for (std::string& note :
         notes_on_given_poses(given_and_found(views_, surfaces_, convention_, result, refined)))
      result.notes.push_back(std::move(note));
  }

  void note_kept_poses(Alignment& result) const {
    std::vector<std::string> names;
    std::size_t given = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      given += views_[i].pose == PoseKind::kGuess && result.views[i].aligned ? 1 : 0;
      if (state_.starts.kept[i] && !state_.starts.laid_on_plane[i] && result.views[i].aligned)
        names.push_back(views_[i].name);
    }
    if (!names.empty())
      result.notes.push_back((names.size() == given ? "the views" : some_of(names)) +
                             " stay at their given poses: refining found none that fit better");
  }

  void note_kept_motions(Alignment& result) const {
    std::vector<std::string> names;
    std::string motion;
    for (const ViewReport& view : result.views) {
      if (!view.aligned || view.kept_motions.empty()) continue;
      names.push_back(view.name);
      if (motion.empty()) motion = view.kept_motions.front().description;
    }
    if (names.empty()) return;
    result.notes.push_back(some_of(names) +
                           ": kept where alignment started along motions that the relief shared "
                           "with other views does not determine, as " +
                           motion);
  }

  // Views that shape placed where another one is, to a sample spacing.
  void note_one_place(Alignment& result) const {
    std::size_t found = 0, same = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!result.views[i].aligned || !state_.starts.found_by_shape[i]) continue;
      ++found;
      const auto is_there = [&](std::size_t j) {
        const RigidMotion between =
            result.views[j].world_from_view.inverse() * result.views[i].world_from_view;
        return j != i && result.views[j].aligned &&
               largest_motion(between, surfaces_[i]) <= coarser_spacing(surfaces_[i], surfaces_[j]);
      };
      bool any = false;
      for (std::size_t j = 0; j < views_.size() && !any; ++j) any = is_there(j);
      same += any ? 1 : 0;
    }
    if (same > 2 && 2 * same > found)
      result.notes.push_back(
          std::to_string(same) +
          " views were found where another one is: right if nothing moved between them; if the "
          "object turned before the camera, what stands still, as a wall or a table, outweighs "
          "it, and masks leave that out");
  }

  std::string names_of_group(const std::vector<std::size_t>& group, std::size_t except) const {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (group[i] == group[except] && i != except) names.push_back(views_[i].name);
    return some_of(names);
  }

  static std::string some_of(const std::vector<std::string>& names) {
    constexpr std::size_t kNamed = 4;  // The report of each view has one line.
    return name_list(names, kNamed);
  }

  std::string reason_unverified(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    if (state_.starts.laid_on_plane[i])
      return "it shares only a plane with other views, to which refining would move it far, and "
             "planes fit wherever views belong; it is kept there, and nothing confirms it; leave "
             "out what stands still, as a wall or a table (a mask per view), and check that masks "
             "are not inverted";
    const ViewVerification& view = state_.verified.views[i];
    if (!view.overlaps)
      return "it overlaps no other view at its pose; it is kept there, and nothing confirms it";
    if (view.violation > 0.0)
      return "other views saw through where a part of it stands; " + check_of_pose_seen_through(i);
    if (is_guess_along_a_motion(i))
      return "its pose was found by its shape, which fits as well when moved by " +
             state_.refined.kept_motions[i].front().description +
             "; check it, or give a guess in world_from_view";
    if (view.deviates_alone)
      return "it deviates from all views that it overlaps by more than any two others do, and by "
             "more than twice as much as usual: its pose is wrong, or its image is mirrored or "
             "bent, or something moved";
    if (view.deviates_with_group)
      return "together with the views that it fits, if any, it deviates from a larger group that "
             "it overlaps, by more than any two views of one group do, and by more than twice as "
             "much as usual: the images of one group are mirrored or bent, or something moved "
             "between them";
    const std::string partners = names_of_group(state_.verified.group, i);
    if (!partners.empty())
      return "it is confirmed only by " + partners + ", which nothing confirms in turn";
    return "it deviates from the views that it overlaps by more than other pairs do";
  }

  // What stands still in the camera's frame is seen through wherever poses carry it. It explains a
  // violation that is not larger.
  std::string check_of_pose_seen_through(std::size_t i) const {
    std::vector<const RangeView*> others;
    std::vector<RigidMotion> world_from_others;
    for (std::size_t j = 0; j < views_.size(); ++j) {
      if (j == i || surfaces_[j].samples().empty()) continue;
      others.push_back(&views_[j]);
      world_from_others.push_back(state_.refined.world_from_view[j]);
    }
    const double tolerance = surfaces_[i].spacing() + kAlike * surfaces_[i].noise();
    const double still = still_fraction(views_[i], state_.refined.world_from_view[i], others,
                                        world_from_others, tolerance);
    if (!(still > 0.0) || still < state_.verified.views[i].violation) return "check its pose";
    return "so many of its samples are where other views have theirs in the camera's frame, "
           "although the poses move them, that these explain it: leave out what stands still, as a "
           "wall or a table (a mask per view), or check its pose";
  }

  // Where two views differ, either may be wrong.
  bool has_other_unit(std::size_t i) const {
    const double relative = relative_spacings_[i];
    const bool sought = views_[i].pose != PoseKind::kKnown || !state_.starts.world_from_view[i];
    return views_.size() > 2 && sought && !state_.verified.views[i].overlaps &&
           given_poses_ != GivenPoses::kTrust &&
           (relative > kOtherUnit || relative < 1.0 / kOtherUnit);
  }

  std::string reason_left_out(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    if (has_other_unit(i)) return reason_other_unit(relative_spacings_[i]);
    if (!state_.starts.world_from_view[i]) return state_.starts.reasons[i];
    if (state_.taken_out[i])
      return std::string(
                 "other views saw through where a part of it would stand at the pose found "
                 "by its shape; ") +
             (views_[i].pose == PoseKind::kAbsent ? "give a guess of its pose"
                                                  : "check its image, and the pose that is given");
    if (state_.roles[i] == ViewRole::kExcluded)
      return "it fits none of the views that it seems to overlap; give a better guess or remove it";
    const std::string partners = names_of_group(state_.refined.group, i);
    if (partners.empty()) return "no pose was found at which it fits the main group";
    return "no pose was found at which its group fits the main group; it is aligned only to " +
           partners;
  }

  static std::string reason_other_unit(double relative_spacing) {
    const bool farther = relative_spacing > 1.0;
    std::ostringstream reason;
    reason << "it overlaps no other view, and its samples are "
           << std::lround(farther ? relative_spacing : 1.0 / relative_spacing) << " times as "
           << (farther ? "far apart" : "near each other")
           << " as those of a typical view: check its unit or depth scale";
    return reason.str();
  }

  const std::vector<RangeView>& views_;
  const std::vector<ViewSurface>& surfaces_;
  const GivenPoses given_poses_;
  const CheckedPoses& checked_;
  const PoseConvention& convention_;
  AlignmentState state_;
  const std::vector<double> relative_spacings_;
};

}  // namespace

Alignment report_alignment(const std::vector<RangeView>& views,
                           const std::vector<ViewSurface>& surfaces, GivenPoses given_poses,
                           const CheckedPoses& checked, const PoseConvention& convention,
                           AlignmentState state) {
  return AlignmentReport(views, surfaces, given_poses, checked, convention, std::move(state))
      .make();
}

}  // namespace relief::registration
