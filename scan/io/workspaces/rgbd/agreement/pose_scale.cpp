#include "scan/io/workspaces/rgbd/agreement/pose_scale.h"

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <vector>

namespace relief {

namespace {

constexpr double kLargest = 1000.0;  // Factor of translations, either way.
constexpr int kSteps = 80;           // From the least to the largest: 1.19 times each.
constexpr int kHalvings = 6;         // Of the step: to 0.3 %.
// How much better than from one place, where only directions matter.
constexpr double kHasParallax = 2.0;

// At poses whose translations are multiplied by each of the factors.
std::vector<std::optional<Disagreement>> disagreements(const ProjectSpec& project,
                                                       const ComparedDepths& compared,
                                                       const std::vector<double>& factors) {
  std::vector<DepthReading> readings;
  for (const double factor : factors)
    readings.push_back({.along_ray = has_ray_lengths(project), .poses = {.unit = factor}});
  return compared.disagreements(project, readings);
}

struct Scale {
  double factor = 1.0;
  Disagreement disagreement;
};

// The factor at which the maps agree best of those at which enough of their pixels meet.
std::optional<Scale> best_of(const ProjectSpec& project, const ComparedDepths& compared,
                             const std::vector<double>& factors, std::size_t least_pixels,
                             std::optional<Scale> best = {}) {
  const auto found = disagreements(project, compared, factors);
  for (std::size_t k = 0; k < factors.size(); ++k)
    if (found[k] && found[k]->pixels >= least_pixels &&
        (!best || found[k]->median < best->disagreement.median))
      best = Scale{factors[k], *found[k]};
  return best;
}

std::optional<Scale> find_scale(const ProjectSpec& project, const ComparedDepths& compared,
                                std::size_t least_pixels) {
  std::vector<double> factors;
  for (int k = 0; k <= kSteps; ++k) factors.push_back(std::pow(kLargest, 2.0 * k / kSteps - 1.0));
  auto best = best_of(project, compared, factors, least_pixels);
  double step = std::pow(kLargest, 2.0 / kSteps);
  for (int i = 0; i < kHalvings && best; ++i) {
    step = std::sqrt(step);
    best =
        best_of(project, compared, {best->factor / step, best->factor * step}, least_pixels, best);
  }
  return best;
}

}  // namespace

void take_pose_scale(ProjectSpec& project, const ComparedDepths& compared) {
  constexpr double kOnePlace = 1e-9;  // Factor that leaves no view apart from another.
  const auto found = disagreements(project, compared, {1.0, kOnePlace});
  const auto &as_given = found[0], &from_one_place = found[1];
  if (!as_given || !from_one_place || as_given->median < kCameraError) return;
  const auto best = find_scale(project, compared, as_given->pixels / 2);
  if (!best || !(as_given->median > kFarBetter * best->disagreement.median) ||
      !(from_one_place->median > kHasParallax * best->disagreement.median))
    return;
  for (ViewSpec& view : project.views)
    if (view.pose != PoseKind::kAbsent) view.world_from_view.translation() *= best->factor;
  char note[240];
  std::snprintf(note, sizeof note,
                "translations of the poses are taken %.3g times, with which the depth maps agree "
                "to %.2g %% of the depth (as given %.2g %%): poses from images have no scale",
                best->factor, 100.0 * best->disagreement.median, 100.0 * as_given->median);
  project.notes.emplace_back(note);
}

}  // namespace relief
