#include "registration/align_once.h"

#include <algorithm>
#include <map>
#include <utility>

#include "registration/alignment_report.h"
#include "registration/given_poses/given_poses.h"
#include "registration/global/starting_poses.h"

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
  Result<AlignedOnce> run(const std::optional<PoseConvention>& convention) {
    auto given = refine_given_poses(surfaces_, views_, starting_, refinement_, convention,
                                    progress_, units_);
    if (!given) return given.error();
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
    return AlignedOnce{report_alignment(views_, surfaces_, starting_.given, given->checked,
                                        given->convention, std::move(state_)),
                       given->convention};
  }

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
  std::vector<RigidMotion> poses_;
  AlignmentState state_;
};

}  // namespace

Result<AlignedOnce> align_once(const std::vector<RangeView>& views,
                               const std::vector<ViewSurface>& surfaces,
                               const AlignOptions& options, const AlignUnits& units,
                               const Progress& progress,
                               const std::optional<PoseConvention>& convention) {
  return Aligning(views, surfaces, options, units, progress).run(convention);
}

}  // namespace relief::registration
