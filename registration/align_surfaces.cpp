#include "registration/align_surfaces.h"

#include <algorithm>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "registration/align_once.h"
#include "registration/given_poses/given_pose_errors.h"
#include "registration/given_poses/given_pose_notes.h"

namespace relief::registration {

namespace {

// Aligns, and once more where the poses that come out show that the guesses err alike, or that
// refining led from them to where views do not belong.
class AligningGuesses {
 public:
  AligningGuesses(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
                  const AlignOptions& options, const AlignUnits& units, const Progress& progress)
      : views_(views), surfaces_(surfaces), options_(options), units_(units), progress_(progress) {}

  Result<Alignment> run() {
    auto once = align_once(views_, surfaces_, options_, units_, progress_);
    if (!once) return once.error();
    Alignment& aligned = once->alignment;
    if (options_.starting_poses.given != GivenPoses::kCheck) return std::move(aligned);
    taken_ = once->convention;
    const bool moved_far = refinement_moved_far(views_, surfaces_, aligned, taken_);
    if (options_.starting_poses.search &&
        (moved_far || has_few_determined_pairs(views_, aligned))) {
      auto found = align_by_shape();
      if (!found) return found;
      if (fits_far_better(surfaces_, *found, aligned)) return instead_of(aligned, *found);
      if (moved_far) doubt_what_shape_does_not_confirm(*found, aligned);
    }
    auto again = align_agreeing_with(aligned);
    if (!again) return again.error();
    if (*again && verified_views(**again) > verified_views(aligned)) return std::move(**again);
    doubt_kept_motions(aligned);
    return std::move(aligned);
  }

 private:
  Result<Alignment> align_by_shape() const {
    AlignOptions options = options_;
    options.starting_poses.given = GivenPoses::kIgnore;
    auto found = align_once(views_, surfaces_, options, units_, progress_);
    if (!found) return found.error();
    return std::move(found->alignment);
  }

  // Refining moved views far, to where they deviate by more than their noise: they may have come to
  // rest anywhere. Those that `found` does not have at the same poses, to a sample spacing, are
  // verified by nothing.
  void doubt_what_shape_does_not_confirm(const Alignment& found, Alignment& aligned) const {
    const auto is_confirmed = [&](std::size_t i, std::size_t j) {
      if (i == j || found.views[i].status != PoseStatus::kVerified ||
          found.views[j].status != PoseStatus::kVerified)
        return false;
      const RigidMotion by_shape =
          found.views[j].world_from_view.inverse() * found.views[i].world_from_view;
      const RigidMotion refined =
          aligned.views[j].world_from_view.inverse() * aligned.views[i].world_from_view;
      return largest_motion(by_shape.inverse() * refined, surfaces_[i]) <=
             coarser_spacing(surfaces_[i], surfaces_[j]);
    };
    for (std::size_t i = 0; i < views_.size(); ++i) {
      ViewReport& view = aligned.views[i];
      bool confirmed = view.status != PoseStatus::kVerified;
      for (std::size_t j = 0; j < views_.size() && !confirmed; ++j) confirmed = is_confirmed(i, j);
      if (confirmed) continue;
      view.status = PoseStatus::kUnverified;
      view.reason =
          "refining moved the views far from their given poses, to where they deviate by more than "
          "their noise, and their shape does not confirm it; check the given poses";
    }
  }

  // Along a motion that a view keeps, its guess is off as guesses are where other views correct
  // them. Up to a sample spacing that is as good as the views tell.
  void doubt_kept_motions(Alignment& aligned) const {
    const double move = median_move(given_and_found(views_, surfaces_, taken_, aligned,
                                                    std::vector<bool>(views_.size(), true)));
    if (!(move > aligned.spacing)) return;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      ViewReport& view = aligned.views[i];
      if (view.status != PoseStatus::kVerified || view.kept_motions.empty() ||
          views_[i].pose != PoseKind::kGuess)
        continue;
      std::ostringstream reason;
      reason << std::setprecision(2)
             << "nothing that it shares with other views tells how far its guess is off along one "
                "motion ("
             << view.kept_motions.front().description
             << "), and where they tell, guesses were off by " << move << " (median)";
      view.status = PoseStatus::kUnverified;
      view.reason = reason.str();
    }
  }

  // From guesses corrected such that they agree with `shown`; nothing where no correction does.
  Result<std::optional<Alignment>> align_agreeing_with(const Alignment& shown) const {
    const auto convention = agreeing_convention(views_, surfaces_, shown, taken_);
    if (!convention) return std::optional<Alignment>();
    auto again = align_once(views_, surfaces_, options_, units_, progress_, convention);
    if (!again) return again.error();
    return std::optional(std::move(again->alignment));
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
          "the given poses are not used: refining them led to where few pairs of views fit, and "
          "the "
          "views fit each other far better at poses found by their shape; --poses trust takes the "
          "given ones");
      // Not refined from the given ones, but what these err by alike shows.
      for (std::string& note : notes_on_given_poses(given_and_found(
               views_, surfaces_, taken_, found, std::vector<bool>(views_.size(), false))))
        found.notes.push_back(std::move(note));
      return std::move(found);
    }
    aligned.notes.push_back(
        "refining the given poses led to where few pairs of views fit, and " +
        std::to_string(verified) +
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

}  // namespace relief::registration
