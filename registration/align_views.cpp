#include "relief/registration/align_views.h"

#include <algorithm>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/calibration/sensor_error_covariance.h"
#include "registration/distinct_views.h"
#include "registration/given_poses/doubted_poses.h"
#include "registration/prepared_views.h"

namespace relief::registration {

namespace {

Result<Alignment> align_distinct(const std::vector<RangeView>& views, const AlignOptions& options,
                                 const Context& context) {
  const auto prepared = prepare_to_align(views, options, context);
  if (!prepared) return prepared.error();
  const auto& [surfaces, units] = *prepared;
  auto aligned = align_surfaces(views, surfaces, options, context.progress, units);
  if (!aligned) return aligned;
  if (!report_progress(context.progress, 0.0, "measuring errors of sensors"))
    return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
  include_sensor_errors(views, surfaces, options.refinement, *aligned);
  doubt_unsettled_poses(views, *aligned);
  doubt_undetermined_poses(views, *aligned);
  return aligned;
}

}  // namespace

bool Alignment::complete() const {
  return std::all_of(views.begin(), views.end(), [](const auto& view) { return view.aligned; });
}

bool Alignment::stands_still() const {
  // Of the deviation. Squares of errors add up: this adds two percent.
  constexpr double kSmallPart = 0.2;
  const double deviation = median_deviation(*this);
  return termination == RefinementTermination::kConverged ||
         (solved() && deviation > 0.0 && last_motion <= kSmallPart * deviation);
}

std::vector<RigidMotion> Alignment::world_from_view() const {
  std::vector<RigidMotion> poses;
  for (const auto& view : views) poses.push_back(view.world_from_view);
  return poses;
}

Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options,
                              const Context& context) {
  return run_in(context, [&]() -> Result<Alignment> {
    const DistinctViews distinct(views);
    auto aligned = align_distinct(distinct.views(), options, context);
    if (!aligned) return aligned;
    if (const auto others = distinct.with_guesses_of_copies(*aligned)) {
      auto again = align_distinct(*others, options, context);
      if (!again) return again;
      if (verified_views(*again) > verified_views(*aligned)) aligned = std::move(again);
    }
    return distinct.with_copies(*std::move(aligned));
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
