#include "relief/registration/align_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/prepared_views.h"
#include "registration/verification/given_poses.h"

namespace relief::registration {

namespace {

// Of the views in a frame the largest verified group, or that of known views.
std::size_t main_group(const PoseVerification& verified, const std::vector<ViewRole>& roles,
                       const std::vector<std::size_t>& frames, std::size_t frame) {
  std::map<std::size_t, std::pair<bool, std::size_t>> weight;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    if (roles[i] == ViewRole::kExcluded || frames[i] != frame) continue;
    auto& [known, size] = weight[verified.group[i]];
    known |= roles[i] == ViewRole::kFixed;
    ++size;
  }
  std::size_t main = roles.size();
  std::pair<bool, std::size_t> most(false, 1);
  for (const auto& [group, w] : weight) {
    if (!(w > most)) continue;
    main = group;
    most = w;
  }
  return main;
}

// Views found by shape that fit none of those they seem to overlap: all their pairs are misfits.
std::vector<bool> find_misfits(const std::vector<bool>& found_by_shape,
                               const std::vector<ViewRole>& roles, const JointRefinement& refined) {
  std::vector<bool> paired(roles.size(), false), fits(roles.size(), false);
  for (const auto& pair : refined.pairs) {
    for (const std::size_t i : {pair.a, pair.b}) {
      paired[i] = true;
      if (pair.status != PairStatus::kMisfit) fits[i] = true;
    }
  }
  std::vector<bool> misfits(roles.size());
  for (std::size_t i = 0; i < roles.size(); ++i)
    misfits[i] = paired[i] && !fits[i] && roles[i] == ViewRole::kFree && found_by_shape[i];
  return misfits;
}

// Units of scans differ by ten at least: mm, cm, m. Samples so many times as far apart as those of
// a typical view, or as near, are of another unit, unless other views confirm them.
constexpr double kOtherUnit = 9.0;

// What the spacing of each view is in that of a typical one.
std::vector<double> relative_spacings(const std::vector<ViewSurface>& surfaces) {
  std::vector<double> spacings;
  for (const ViewSurface& surface : surfaces)
    if (!surface.samples().empty()) spacings.push_back(surface.spacing());
  const double typical = spacings.empty() ? 0.0 : quantile(std::move(spacings), 0.5);
  std::vector<double> relative;
  for (const ViewSurface& surface : surfaces)
    relative.push_back(typical > 0.0 && !surface.samples().empty() ? surface.spacing() / typical
                                                                   : 1.0);
  return relative;
}

// One alignment on its way from surfaces to a report.
class Aligning {
 public:
  Aligning(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
           const AlignOptions& options, const AlignUnits& units, const Progress& progress)
      : views_(views),
        surfaces_(surfaces),
        starting_(options.starting_poses),
        refinement_(options.refinement),
        units_(units),
        progress_(progress),
        relative_spacings_(relative_spacings(surfaces)) {}

  Result<Alignment> run() {
    auto given = refine_given_poses(surfaces_, views_, starting_, refinement_, progress_, units_);
    if (!given) return given.error();
    auto starts =
        find_starting_poses(surfaces_, views_, given->checked, starting_, progress_, units_);
    if (!starts) return starts.error();
    starts_ = std::move(*starts);
    take_roles();
    if (unchanged(given->checked)) {
      refined_ = std::move(given->refined);
      verified_ = std::move(given->verified);
    } else if (const auto done = refine_all(); !done) {
      return done.error();
    }
    return report(given->checked, given->convention);
  }

 private:
  void take_roles() {
    taken_out_.assign(views_.size(), false);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto& start = starts_.world_from_view[i];
      poses_.push_back(start.value_or(views_[i].world_from_view));
      roles_.push_back(!start                               ? ViewRole::kExcluded
                       : views_[i].pose == PoseKind::kKnown ? ViewRole::kFixed
                                                            : ViewRole::kFree);
    }
  }

  // Whether all poses are the given ones, already refined together.
  bool unchanged(const CheckedPoses& checked) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (starts_.found_by_shape[i] ||
          starts_.world_from_view[i].has_value() != checked.world_from_view[i].has_value())
        return false;
    return true;
  }

  // Views found by shape that turn out to fit nowhere, or that others contradict, are taken out and
  // the rest is refined again from where it started, free of their influence.
  Result<void> refine_all() {
    for (;;) {
      auto refined = units_.refine_jointly(surfaces_, poses_, roles_, refinement_, progress_);
      if (!refined) return refined.error();
      refined_ = std::move(*refined);
      const auto misfits = find_misfits(starts_.found_by_shape, roles_, refined_);
      if (std::find(misfits.begin(), misfits.end(), true) != misfits.end()) {
        for (std::size_t i = 0; i < roles_.size(); ++i)
          if (misfits[i]) roles_[i] = ViewRole::kExcluded;
        continue;
      }
      if (!report_progress(progress_, 0.0, "verifying poses"))
        return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
      verified_ = verify_poses(surfaces_, refined_.world_from_view, roles_,
                               verification_options(starting_));
      const auto worst = most_contradicted();
      if (!worst) {
        if (std::find(taken_out_.begin(), taken_out_.end(), true) != taken_out_.end())
          choose_frame();
        return {};
      }
      roles_[*worst] = ViewRole::kExcluded;
      taken_out_[*worst] = true;
    }
  }

  // That in which most views are left. Given poses keep theirs; a view that is left alone has
  // nothing to confirm it.
  void choose_frame() {
    std::map<std::size_t, std::vector<std::size_t>> left;
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      if (roles_[i] == ViewRole::kExcluded) continue;
      if (starts_.frame[i] == 0 && !starts_.found_by_shape[i]) return;
      left[starts_.frame[i]].push_back(i);
    }
    for (const auto& [frame, views] : left)
      if (views.size() > left[frame_].size()) frame_ = frame;
    if (left[frame_].size() == 1) taken_out_[left[frame_].front()] = true;
  }

  // Of the contradicted views that shape placed, the one against which most speaks. One at a time:
  // a wrong view contradicts right ones.
  std::optional<std::size_t> most_contradicted() const {
    std::optional<std::size_t> most;
    double excess = 0.0;
    for (std::size_t i = 0; i < roles_.size(); ++i) {
      const auto& view = verified_.views[i];
      if (roles_[i] != ViewRole::kFree || !starts_.found_by_shape[i] || !contradicted(i) ||
          view.violation - view.support <= excess)
        continue;
      excess = view.violation - view.support;
      most = i;
    }
    return most;
  }

  Alignment report(const CheckedPoses& checked, const PoseConvention& convention) {
    Alignment result;
    result.notes = starts_.notes;
    if (!convention.as_given())
      result.notes.push_back("the given poses are taken as " + convention.describe() +
                             ": so they bring the views together, and as world_from_view they do "
                             "not; --poses trust takes them as they are");
    const std::size_t main = main_group(verified_, roles_, starts_.frame, frame_);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      ViewReport view;
      view.name = views_[i].name;
      view.world_from_view = refined_.world_from_view[i];
      view.pose_std = refined_.pose_std[i];
      view.pose_covariance = refined_.pose_covariance[i];
      view.aligned = starts_.frame[i] == frame_ && !taken_out_[i] &&
                     roles_[i] != ViewRole::kExcluded && !has_other_unit(i);
      const bool confirmed = (verified_.group[i] == main && !contradicted(i)) ||
                             views_.size() == 1 || views_[i].pose == PoseKind::kKnown;
      view.status = !view.aligned ? PoseStatus::kLeftOut
                    : confirmed   ? PoseStatus::kVerified
                                  : PoseStatus::kUnverified;
      if (view.status == PoseStatus::kUnverified) view.reason = reason_unverified(i);
      if (view.status == PoseStatus::kLeftOut) view.reason = reason_left_out(i);
      result.views.push_back(std::move(view));
    }
    note_moves(checked, result);
    if (views_.size() == 1) result.notes.push_back("one view only: nothing to align");
    result.pairs = std::move(refined_.pairs);
    result.termination = refined_.termination;
    result.iterations = refined_.iterations;
    result.rms = refined_.rms;
    result.solves = std::move(refined_.solves);
    result.loops = std::move(refined_.loops);
    return result;
  }

  // Whether more speaks against the pose than confirms it: what only allows the pose keeps it.
  bool contradicted(std::size_t i) const {
    return verified_.views[i].violation > verified_.views[i].support;
  }

  void note_moves(const CheckedPoses& checked, Alignment& result) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (starts_.found_by_shape[i] && starts_.frame[i] == frame_ &&
          (checked.refuted[i] || checked.world_from_view[i]))
        result.notes.push_back(
            "view " + views_[i].name + ": its given pose " +
            (checked.refuted[i] ? "stands where other views saw through" : "is not confirmed") +
            "; a pose that fits was found by its shape instead");
  }

  std::string names_of_group(const std::vector<std::size_t>& group, std::size_t except) const {
    std::string names;
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (group[i] == group[except] && i != except)
        names += (names.empty() ? "" : ", ") + views_[i].name;
    return names;
  }

  std::string reason_unverified(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    const ViewVerification& view = verified_.views[i];
    if (!view.overlaps)
      return "it overlaps no other view at its pose; it is kept there, and nothing confirms it";
    if (view.violation > 0.0)
      return "other views saw through where a part of it stands; check its pose";
    const std::string partners = names_of_group(verified_.group, i);
    if (!partners.empty())
      return "it is confirmed only by " + partners + ", which nothing confirms in turn";
    return "it deviates from the views that it overlaps by more than other pairs do";
  }

  // Where two views differ, either may be wrong.
  bool has_other_unit(std::size_t i) const {
    const double relative = relative_spacings_[i];
    return views_.size() > 2 && roles_[i] == ViewRole::kFree && !verified_.views[i].overlaps &&
           starting_.given != GivenPoses::kTrust &&
           (relative > kOtherUnit || relative < 1.0 / kOtherUnit);
  }

  std::string reason_left_out(std::size_t i) const {
    if (surfaces_[i].samples().empty())
      return "it has no usable samples: none lies off all boundaries with a surface normal";
    if (has_other_unit(i)) return reason_other_unit(relative_spacings_[i]);
    if (!starts_.world_from_view[i]) return starts_.reasons[i];
    if (taken_out_[i])
      return "other views saw through where a part of it would stand at the pose found by its "
             "shape; give a guess of its pose";
    if (roles_[i] == ViewRole::kExcluded)
      return "it fits none of the views that it seems to overlap; give a better guess or remove it";
    return "no pose was found at which its group fits the main group; it is aligned only to " +
           names_of_group(refined_.group, i);
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
  StartingPoseOptions starting_;
  JointRefinementOptions refinement_;
  const AlignUnits& units_;
  const Progress& progress_;
  const std::vector<double> relative_spacings_;
  StartingPoses starts_;
  std::vector<RigidMotion> poses_;
  std::vector<ViewRole> roles_;
  std::size_t frame_ = 0;        // Of StartingPoses, that of the result.
  std::vector<bool> taken_out_;  // Taken out since more speaks against the pose than for it.
  JointRefinement refined_;
  PoseVerification verified_;
};

}  // namespace

bool Alignment::complete() const {
  return std::all_of(views.begin(), views.end(), [](const auto& view) { return view.aligned; });
}

std::vector<RigidMotion> Alignment::world_from_view() const {
  std::vector<RigidMotion> poses;
  for (const auto& view : views) poses.push_back(view.world_from_view);
  return poses;
}

Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options,
                              const Context& context) {
  return run_in(context, [&]() -> Result<Alignment> {
    const auto prepared = prepare_to_align(views, options, context);
    if (!prepared) return prepared.error();
    const auto& [surfaces, units] = *prepared;
    return Aligning(views, surfaces, options, units, context.progress).run();
  });
}

std::string_view to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::kVerified:
      return "verified";
    case PoseStatus::kUnverified:
      return "unverified";
    case PoseStatus::kLeftOut:
      return "left out";
  }
  return "unknown";
}

}  // namespace relief::registration
