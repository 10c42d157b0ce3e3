#include "registration/align_surfaces.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "registration/align_once.h"
#include "registration/given_poses/doubted_poses.h"
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
      if (moved_far) doubt_what_shape_does_not_confirm(surfaces_, *found, aligned);
    }
    auto again = align_agreeing_with(aligned);
    if (!again) return again.error();
    if (*again && verified_views(**again) > verified_views(aligned)) return std::move(**again);
    doubt_kept_motions(views_, surfaces_, taken_, aligned);
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
