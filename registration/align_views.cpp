#include "relief/registration/align_views.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/alignment_report.h"
#include "registration/calibration/sensor_error_covariance.h"
#include "registration/prepared_views.h"
#include "registration/verification/given_pose_errors.h"
#include "registration/verification/given_poses.h"

namespace relief::registration {

namespace {

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
        progress_(progress) {}

  // Takes guesses in `convention`; without one in what find_pose_convention() says.
  Result<Alignment> run(const std::optional<PoseConvention>& convention = {}) {
    auto given = refine_given_poses(surfaces_, views_, starting_, refinement_, convention,
                                    progress_, units_);
    if (!given) return given.error();
    convention_ = given->convention;
    auto starts =
        find_starting_poses(surfaces_, views_, given->checked, starting_, progress_, units_);
    if (!starts) return starts.error();
    state_.starts = std::move(*starts);
    take_roles();
    if (unchanged(given->checked)) {
      state_.refined = std::move(given->refined);
      state_.verified = std::move(given->verified);
    } else if (const auto done = refine_all(); !done) {
      return done.error();
    } else {
      take_covariances_of_kept(*given);
    }
    return report_alignment(views_, surfaces_, starting_.given, given->checked, given->convention,
                            std::move(state_));
  }

  const PoseConvention& convention() const { return convention_; }

 private:
  void take_roles() {
    state_.taken_out.assign(views_.size(), false);
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto& start = state_.starts.world_from_view[i];
      poses_.push_back(start.value_or(views_[i].world_from_view));
      state_.roles.push_back(!start ? ViewRole::kExcluded
                             : views_[i].pose == PoseKind::kKnown || state_.starts.kept[i]
                                 ? ViewRole::kFixed
                                 : ViewRole::kFree);
    }
  }

  // Views that keep their given poses were held, as if these were exact.
  void take_covariances_of_kept(const RefinedGivenPoses& given) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!state_.starts.kept[i]) continue;
      state_.refined.pose_covariance[i] = given.refined.pose_covariance[i];
      state_.refined.pose_std[i] = given.refined.pose_std[i];
    }
  }

  // Whether all poses are the given ones, already refined together.
  bool unchanged(const CheckedPoses& checked) const {
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (state_.starts.found_by_shape[i] ||
          state_.starts.world_from_view[i].has_value() != checked.world_from_view[i].has_value())
        return false;
    return true;
  }

  // Views found by shape that turn out to fit nowhere, or that others contradict, are taken out and
  // the rest is refined again from where it started, free of their influence.
  Result<void> refine_all() {
    for (;;) {
      auto refined = units_.refine_jointly(surfaces_, poses_, state_.roles, refinement_, progress_);
      if (!refined) return refined.error();
      state_.refined = std::move(*refined);
      const auto misfits = find_misfits(state_.starts.found_by_shape, state_.roles, state_.refined);
      if (std::find(misfits.begin(), misfits.end(), true) != misfits.end()) {
        for (std::size_t i = 0; i < state_.roles.size(); ++i)
          if (misfits[i]) state_.roles[i] = ViewRole::kExcluded;
        continue;
      }
      if (!report_progress(progress_, 0.0, "verifying poses"))
        return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
      state_.verified = verify_poses(surfaces_, state_.refined.world_from_view,
                                     without_views(state_.starts.laid_on_plane, state_.roles),
                                     verification_options(starting_));
      const auto worst = most_contradicted();
      if (!worst) {
        if (std::find(state_.taken_out.begin(), state_.taken_out.end(), true) !=
            state_.taken_out.end())
          choose_frame();
        return {};
      }
      state_.roles[*worst] = ViewRole::kExcluded;
      state_.taken_out[*worst] = true;
    }
  }

  // That in which most views are left. Given poses keep theirs; a view that is left alone has
  // nothing to confirm it.
  void choose_frame() {
    std::map<std::size_t, std::vector<std::size_t>> left;
    for (std::size_t i = 0; i < state_.roles.size(); ++i) {
      if (state_.roles[i] == ViewRole::kExcluded) continue;
      if (state_.starts.frame[i] == 0 && !state_.starts.found_by_shape[i]) return;
      left[state_.starts.frame[i]].push_back(i);
    }
    for (const auto& [frame, views] : left)
      if (views.size() > left[state_.frame].size()) state_.frame = frame;
    if (left[state_.frame].size() == 1) state_.taken_out[left[state_.frame].front()] = true;
  }

  // Of the contradicted views that shape placed, the one against which most speaks. One at a time:
  // a wrong view contradicts right ones.
  std::optional<std::size_t> most_contradicted() const {
    std::optional<std::size_t> most;
    double excess = 0.0;
    for (std::size_t i = 0; i < state_.roles.size(); ++i) {
      const auto& view = state_.verified.views[i];
      if (state_.roles[i] != ViewRole::kFree || !state_.starts.found_by_shape[i] ||
          view.violation - view.support <= excess)
        continue;
      excess = view.violation - view.support;
      most = i;
    }
    return most;
  }

  const std::vector<RangeView>& views_;
  const std::vector<ViewSurface>& surfaces_;
  StartingPoseOptions starting_;
  JointRefinementOptions refinement_;
  const AlignUnits& units_;
  const Progress& progress_;
  PoseConvention convention_;
  std::vector<RigidMotion> poses_;
  AlignmentState state_;
};

// Aligns, and once more where the poses that come out show that the guesses err alike, or that
// refining led from them to where views do not belong.
class AligningGuesses {
 public:
  AligningGuesses(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
                  const AlignOptions& options, const AlignUnits& units, const Progress& progress)
      : views_(views), surfaces_(surfaces), options_(options), units_(units), progress_(progress) {}

  Result<Alignment> run() {
    Aligning aligning(views_, surfaces_, options_, units_, progress_);
    auto aligned = aligning.run();
    if (!aligned || options_.starting_poses.given != GivenPoses::kCheck) return aligned;
    taken_ = aligning.convention();
    if (options_.starting_poses.search &&
        refinement_moved_far(views_, surfaces_, *aligned, taken_)) {
      auto found = align_by_shape();
      if (!found) return found;
      if (fits_far_better(surfaces_, *found, *aligned)) return instead_of(*aligned, *found);
    }
    auto again = align_agreeing_with(*aligned);
    if (!again) return again.error();
    const bool more = *again && verified_views(**again) > verified_views(*aligned);
    return more ? std::move(**again) : std::move(*aligned);
  }

 private:
  Result<Alignment> align_by_shape() const {
    AlignOptions options = options_;
    options.starting_poses.given = GivenPoses::kIgnore;
    return Aligning(views_, surfaces_, options, units_, progress_).run();
  }

  // From guesses corrected such that they agree with `shown`; nothing where no correction does.
  Result<std::optional<Alignment>> align_agreeing_with(const Alignment& shown) const {
    const auto convention = agreeing_convention(views_, surfaces_, shown, taken_);
    if (!convention) return std::optional<Alignment>();
    auto again = Aligning(views_, surfaces_, options_, units_, progress_).run(convention);
    if (!again) return again.error();
    return std::optional(std::move(*again));
  }

  // `found` fits far better. No view is given up for that: `aligned` stays with a note where it has
  // more.
  Result<Alignment> instead_of(Alignment& aligned, Alignment& found) const {
    const std::size_t verified = verified_views(found), most = verified_views(aligned);
    auto again = align_agreeing_with(found);
    if (!again) return again.error();
    if (*again && verified_views(**again) >= std::max(verified, most) &&
        fits_far_better(surfaces_, **again, aligned))
      return std::move(**again);
    if (verified >= most) {
      found.notes.emplace_back(
          "the given poses are not used: refining them led far away, and the views fit each other "
          "far better at poses found by their shape; --poses trust takes the given ones");
      return std::move(found);
    }
    aligned.notes.push_back(
        "refining led far away from the given poses, and " + std::to_string(verified) +
        " views fit each other far better at poses found by their shape: check the given poses, or "
        "look at the others with --poses ignore");
    return std::move(aligned);
  }

  const std::vector<RangeView>& views_;
  const std::vector<ViewSurface>& surfaces_;
  const AlignOptions& options_;
  const AlignUnits& units_;
  const Progress& progress_;
  PoseConvention taken_;  // The convention in which the guesses were taken.
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

Result<Alignment> align_surfaces(const std::vector<RangeView>& views,
                                 const std::vector<ViewSurface>& surfaces,
                                 const AlignOptions& options, const Progress& progress,
                                 const AlignUnits& units) {
  return AligningGuesses(views, surfaces, options, units, progress).run();
}

std::size_t verified_views(const Alignment& alignment) {
  return static_cast<std::size_t>(std::ranges::count_if(
      alignment.views,
      [](const ViewReport& view) { return view.status == PoseStatus::kVerified; }));
}

Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options,
                              const Context& context) {
  return run_in(context, [&]() -> Result<Alignment> {
    const auto prepared = prepare_to_align(views, options, context);
    if (!prepared) return prepared.error();
    const auto& [surfaces, units] = *prepared;
    auto aligned = align_surfaces(views, surfaces, options, context.progress, units);
    if (!aligned) return aligned;
    if (!report_progress(context.progress, 0.0, "measuring errors of sensors"))
      return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
    include_sensor_errors(views, surfaces, options.refinement, *aligned);
    return aligned;
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
