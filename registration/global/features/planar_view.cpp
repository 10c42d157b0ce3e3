#include "registration/global/features/planar_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

constexpr int kFaces = 4;  // Prisms show as many at once.
// Fraction of the samples. With it `relief_coarse_runs --boxes` places no view wrongly
// (docs/results.md).
constexpr double kPlanarFraction = 0.85;

// Bounds of the time. 800 samples tell a fraction of 0.85 to 1.3 %, and 40 seeds miss a face of a
// tenth of them once in 68 times (0.9^40).
constexpr std::size_t kProbes = 800, kSeeds = 40;
// How far from a plane its samples are: noise [standard deviations], which 0.3 % of a Gaussian
// exceeds, and what sampling and calibration add [sample spacings], as much as poses may show of it
// (VerificationThresholds::max_coherent_rms).
constexpr double kNoiseDeviations = 3.0, kSpacings = 0.2;
// The first guess of a plane is from one sample's normal, so samples far from it may be missed: it
// is fitted again as the tolerance falls to what noise explains [tolerances]. Each fit halves it:
// three reach 1, the fourth uses what that found.
constexpr double kFirstTolerance = 8.0;
constexpr int kFits = 4;

struct Plane {
  Eigen::Vector3d point, normal;
  double distance(const Eigen::Vector3d& p) const { return std::abs(normal.dot(p - point)); }
};

struct Probe {
  SurfacePoint at;
  double tolerance;  // Distance from a plane that it is on, at most [unit].
};

std::vector<Probe> probes_of(const ViewSurface& view) {
  std::vector<Probe> probes;
  for (std::size_t i = 0; i < std::min(kProbes, view.samples().size()); ++i) {
    const SurfacePoint sample = view.sample(view.samples()[i]);
    probes.push_back(
        {sample, kNoiseDeviations * view.noise_at(sample) + kSpacings * view.spacing()});
  }
  return probes;
}

// Those that are as far from the plane as so many of their tolerances at most.
std::vector<std::size_t> near(const Plane& plane, const std::vector<Probe>& probes,
                              double tolerances) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < probes.size(); ++i)
    if (plane.distance(probes[i].at.point) <= tolerances * probes[i].tolerance) found.push_back(i);
  return found;
}

Plane fitted(const std::vector<Probe>& probes, const std::vector<std::size_t>& chosen) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weights = 0.0;
  const auto weight = [&](std::size_t i) { return 1.0 / std::pow(probes[i].tolerance, 2); };
  for (const std::size_t i : chosen) {
    mean += weight(i) * probes[i].at.point;
    weights += weight(i);
  }
  mean /= weights;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : chosen) {
    const Eigen::Vector3d offset = probes[i].at.point - mean;
    scatter += weight(i) * offset * offset.transpose();
  }
  return {mean, eigen_decomposition(scatter).eigenvectors().col(0)};
}

// The points of the plane that most of them are on. pcl::SACSegmentation takes twelve times as long
// for it, 74 ms a view, and prints.
std::vector<std::size_t> largest_face(const std::vector<Probe>& probes) {
  std::vector<std::size_t> largest;
  for (std::size_t seed = 0; seed < std::min(kSeeds, probes.size()); ++seed) {
    Plane plane{probes[seed].at.point, probes[seed].at.normal};
    double reach = kFirstTolerance;
    auto face = near(plane, probes, reach);
    for (int fit = 0; fit < kFits && face.size() >= 3; ++fit) {
      plane = fitted(probes, face);
      reach = std::max(1.0, 0.5 * reach);
      face = near(plane, probes, reach);
    }
    if (face.size() > largest.size()) largest = std::move(face);
  }
  return largest;
}

}  // namespace

double planar_fraction(const ViewSurface& view, int planes) {
  auto probes = probes_of(view);
  const std::size_t all = probes.size();
  if (all == 0) return 0.0;
  for (int k = 0; k < planes && !probes.empty(); ++k) {
    const auto face = largest_face(probes);
    for (auto i = face.rbegin(); i != face.rend(); ++i)
      probes.erase(probes.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  return 1.0 - static_cast<double>(probes.size()) / static_cast<double>(all);
}

bool is_mostly_planar(const ViewSurface& view) {
  return planar_fraction(view, kFaces) >= kPlanarFraction;
}

}  // namespace relief::registration
