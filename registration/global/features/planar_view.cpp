#include "registration/global/features/planar_view.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "registration/surface/largest_plane.h"

namespace relief::registration {

namespace {

constexpr int kFaces = 4;  // Prisms show as many at once.
// Fraction of the samples. With it `relief_coarse_runs --boxes` places no view wrongly
// (docs/results.md).
constexpr double kPlanarFraction = 0.85;

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

}  // namespace

double planar_fraction(const ViewSurface& view, int planes) {
  auto probes = probes_of(view);
  const std::size_t all = probes.size();
  if (all == 0) return 0.0;
  for (int k = 0; k < planes && !probes.empty(); ++k) {
    const auto face = largest_plane(probes);
    for (auto i = face.rbegin(); i != face.rend(); ++i)
      probes.erase(probes.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  return 1.0 - static_cast<double>(probes.size()) / static_cast<double>(all);
}

bool is_mostly_planar(const ViewSurface& view) {
  return planar_fraction(view, kFaces) >= kPlanarFraction;
}

}  // namespace relief::registration
