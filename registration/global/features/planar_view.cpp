#include "registration/global/features/planar_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "registration/surface/largest_plane.h"

namespace relief::registration {

namespace {

// Fraction of the samples. With it `relief_coarse_runs --boxes` places no view wrongly
// (docs/results.md).
constexpr double kPlanarFraction = 0.85;
constexpr double kDominantFraction =
    0.6;  // Stacks of boxes have 0.64 and more, furnished rooms less.

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

}  // namespace relief::registration
