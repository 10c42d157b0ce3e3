#include "registration/starting_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "registration/search_schedule.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr std::size_t kProbes = 500;
constexpr double kSearchRadii = 0.3;
constexpr int kFewCorrespondences = 200;
constexpr int kManyCorrespondences = 1000;

// Where a pose of `view` relative to its neighbour may come from.
struct Candidate {
  RigidMotion reference_from_view = RigidMotion::Identity();
  double score = 0.0;  // Overlap less contradiction; 0 when it fails.
  double overlap = 0.0;
};

// The object turned by `angle` about an axis in the sensor's vertical plane, `tilt` off the y axis,
// through a point behind the mean of the two visible surfaces.
RigidMotion turn(const ViewSurface& reference, const ViewSurface& view, double angle, double tilt) {
  const Eigen::Vector3d axis(0.0, std::cos(tilt), std::sin(tilt));
  const auto middle = [](const ViewSurface& surface) {
    const Eigen::Vector3d towards_sensor = surface.mean_normal();
    return Eigen::Vector3d(surface.centre() - 0.5 * surface.radius() * towards_sensor);
  };
  const Eigen::Vector3d centre = 0.5 * (middle(reference) + middle(view));
  return Eigen::Translation3d(centre) * Eigen::AngleAxisd(angle, axis) *
         Eigen::Translation3d(-centre);
}

std::vector<RigidMotion> hypotheses(const ViewSurface& reference, const ViewSurface& view,
                                    std::size_t views) {
  std::vector<RigidMotion> list = {RigidMotion::Identity()};
  for (const double angle : {360.0 / static_cast<double>(views), 15.0, 30.0, 45.0, 60.0, 90.0})
    for (const double tilt : {0.0, -20.0, 20.0, -40.0, 40.0})
      for (const double sign : {1.0, -1.0})
        list.push_back(
            turn(reference, view, sign * angle * kRadiansPerDegree, tilt * kRadiansPerDegree));
  return list;
}

Candidate try_pose(const ViewSurface& reference, const ViewSurface& view, const RigidMotion& guess,
                   int correspondences, const StartingPoseOptions& options) {
  IcpOptions icp;
  icp.association = options.association;
  icp.correspondences = correspondences;
  icp.tolerance = 0.02;
  icp.max_iterations = 20;
  icp.search_distance = kSearchRadii * std::min(reference.radius(), view.radius());
  const IcpResult fit = align_pair(view, reference, guess, icp);
  Candidate candidate{fit.target_from_source, 0.0, fit.overlap};
  if (!fit.usable() || fit.overlap < options.min_overlap) return candidate;
  const double spacing = std::max(view.spacing(), reference.spacing());
  const double noise = std::hypot(view.noise(), reference.noise());
  const double margin = finest_search_distance(spacing, noise);
  const double against =
      std::max(contradiction(view, reference, fit.target_from_source, margin),
               contradiction(reference, view, fit.target_from_source.inverse(), margin));
  if (fit.rms <= largest_plausible_rms(spacing, noise) && against <= options.max_contradiction)
    candidate.score = fit.overlap - against;
  return candidate;
}

Candidate best_candidate(const ViewSurface& reference, const ViewSurface& view, std::size_t views,
                         const std::optional<RigidMotion>& last_turn,
                         const StartingPoseOptions& options) {
  if (last_turn) {  // A turntable mostly goes on as it did.
    const Candidate next = try_pose(reference, view, *last_turn, kManyCorrespondences, options);
    if (next.score > 0.0) return next;
  }
  const std::vector<RigidMotion> guesses = hypotheses(reference, view, views);
  std::vector<Candidate> candidates(guesses.size());
  parallel_for(guesses.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      candidates[i] = try_pose(reference, view, guesses[i], kFewCorrespondences, options);
  });
  const auto best =
      std::max_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  if (best->score <= 0.0) return *best;
  return try_pose(reference, view, best->reference_from_view, kManyCorrespondences, options);
}

std::string note(const RangeView& view, const RangeView& reference, const Candidate& found) {
  char text[160];
  std::snprintf(text, sizeof text, ", turned by %.1f deg (overlap %.2f); check it",
                rotation_angle(found.reference_from_view) / kRadiansPerDegree, found.overlap);
  return "view " + view.name + " has no pose: started from its neighbour " + reference.name + text;
}

}  // namespace

double contradiction(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, double margin) {
  const std::size_t probes = std::min(kProbes, source.samples().size());
  if (!target.can_project() || probes == 0) return 0.0;
  std::size_t in_front = 0;
  for (std::size_t i = 0; i < probes; ++i) {
    const Eigen::Vector3d point = target_from_source * source.sample(source.samples()[i]).point;
    const auto pixel = target.project(point);
    const auto seen = pixel ? target.at(*pixel) : std::nullopt;
    // Points in front of a surface are on the side of its normal.
    if (seen && (point - seen->point).dot(seen->normal) > margin) ++in_front;
  }
  return static_cast<double>(in_front) / static_cast<double>(probes);
}

namespace {

// Without any, the first view with samples defines the world.
std::vector<std::optional<RigidMotion>> given_poses(const std::vector<ViewSurface>& surfaces,
                                                    const std::vector<RangeView>& views) {
  std::vector<std::optional<RigidMotion>> poses(views.size());
  bool any = false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].pose == PoseKind::kAbsent) continue;
    poses[i] = views[i].world_from_view;
    any = true;
  }
  for (std::size_t i = 0; i < views.size() && !any; ++i) {
    if (surfaces[i].samples().empty()) continue;
    poses[i] = RigidMotion::Identity();
    any = true;
  }
  return poses;
}

}  // namespace

Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const StartingPoseOptions& options,
                                          const Progress& progress) {
  const std::size_t count = views.size();
  StartingPoses result;
  result.world_from_view = given_poses(surfaces, views);

  // From every placed view its neighbours in the order of the scans, until no more can be placed.
  std::optional<RigidMotion> last_turn;
  std::vector<std::pair<std::size_t, std::size_t>> failed;
  for (bool placed_one = true; placed_one;) {
    placed_one = false;
    for (std::size_t i = 0; i < count; ++i) {
      for (const std::size_t r : {(i + count - 1) % count, (i + 1) % count}) {
        if (result.world_from_view[i] || !result.world_from_view[r]) continue;
        if (surfaces[i].samples().empty() || surfaces[r].samples().empty()) continue;
        if (std::find(failed.begin(), failed.end(), std::pair(i, r)) != failed.end()) continue;
        if (!report_progress(progress, static_cast<double>(i) / static_cast<double>(count),
                             "looking for starting poses"))
          return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
        const bool forward = r == (i + count - 1) % count;
        auto expected = last_turn;
        if (expected && !forward) expected = expected->inverse();
        const Candidate found = best_candidate(surfaces[r], surfaces[i], count, expected, options);
        if (found.score <= 0.0) {
          failed.emplace_back(i, r);
          continue;
        }
        result.world_from_view[i] = *result.world_from_view[r] * found.reference_from_view;
        last_turn = forward ? found.reference_from_view : found.reference_from_view.inverse();
        result.notes.push_back(note(views[i], views[r], found));
        placed_one = true;
      }
    }
  }
  return result;
}

}  // namespace relief
