#include "registration/global/features/planar_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "registration/surface/largest_plane.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Fraction of the samples. With it `relief_coarse_runs --boxes` places no view wrongly
// (docs/results.md).
constexpr double kPlanarFraction = 0.85;
constexpr double kDominantFraction =
    0.6;  // Stacks of boxes have 0.64 and more, furnished rooms less.

// Clear of a plane: as many as judge_free_space() looks at.
constexpr std::size_t kFewestClear = 500;

// Bounds the time. 800 samples tell a fraction of 0.85 to 1.3 %.
constexpr std::size_t kProbes = 800;

std::vector<PlaneProbe> probes_of(const ViewSurface& view) {
  std::vector<PlaneProbe> probes;
  for (std::size_t i = 0; i < std::min(kProbes, view.samples().size()); ++i) {
    const SurfacePoint sample = view.sample(view.samples()[i]);
    probes.push_back(
        {sample.point, sample.normal, plane_tolerance(view.noise_at(sample), view.spacing())});
  }
  return probes;
}

// The samples that stand clear of the plane that is most of a view; none where there is no such
// plane, or where they are too few.
std::vector<std::uint32_t> samples_clear_of_plane(const ViewSurface& view) {
  std::vector<std::uint32_t> clear;
  const FlatFaces plane = find_flat_faces(view, 1);
  if (!planes_dominate(plane)) return clear;
  for (const std::uint32_t i : view.samples())
    if (plane.is_off_plane(view.sample(i).point, kClearOfFaces * view.spacing()))
      clear.push_back(i);
  if (clear.size() < kFewestClear) clear.clear();
  return clear;
}

}  // namespace

bool FlatFaces::is_off_plane(const Eigen::Vector3d& point, double distance) const {
  return std::none_of(faces.begin(), faces.end(), [&](const Face& face) {
    return std::abs(face.normal.dot(point - face.point)) <= distance;
  });
}

FlatFaces find_flat_faces(const ViewSurface& view, int count) {
  FlatFaces found;
  auto probes = probes_of(view);
  const std::size_t all = probes.size();
  if (all == 0) return found;
  for (int k = 0; k < count && !probes.empty(); ++k) {
    const auto face = largest_plane(probes);
    found.faces.push_back({face.point, face.normal});
    for (auto i = face.probes.rbegin(); i != face.probes.rend(); ++i)
      probes.erase(probes.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  found.fraction = 1.0 - static_cast<double>(probes.size()) / static_cast<double>(all);
  return found;
}

bool is_mostly_planar(const FlatFaces& view) { return view.fraction >= kPlanarFraction; }

bool planes_dominate(const FlatFaces& view) { return view.fraction >= kDominantFraction; }

std::vector<ViewSurface> without_dominant_planes(const std::vector<ViewSurface>& views) {
  auto clear = parallel_map<std::vector<std::uint32_t>>(
      views.size(), [&](std::size_t i) { return samples_clear_of_plane(views[i]); });
  std::vector<ViewSurface> parts;
  if (std::ranges::all_of(clear, [](const auto& samples) { return samples.empty(); })) return parts;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto all = views[i].samples();
    if (clear[i].empty()) clear[i].assign(all.begin(), all.end());
    parts.push_back(views[i].part(std::move(clear[i])));
  }
  return parts;
}

}  // namespace relief::registration
