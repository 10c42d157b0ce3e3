#include "registration/surface/largest_plane.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

// Bounds the time: 40 seeds miss a face of a tenth of the samples once in 68 times (0.9^40).
constexpr std::size_t kSeeds = 40;
// Noise [standard deviations], which 0.3 % of a Gaussian exceeds, and what sampling and calibration
// add [sample spacings], as much as poses may show of it
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

// Those that are as far from the plane as so many of their tolerances at most.
std::vector<std::size_t> near(const Plane& plane, const std::vector<PlaneProbe>& probes,
                              double tolerances) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < probes.size(); ++i)
    if (plane.distance(probes[i].point) <= tolerances * probes[i].tolerance) found.push_back(i);
  return found;
}

Plane fitted(const std::vector<PlaneProbe>& probes, const std::vector<std::size_t>& chosen) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weights = 0.0;
  const auto weight = [&](std::size_t i) { return 1.0 / std::pow(probes[i].tolerance, 2); };
  for (const std::size_t i : chosen) {
    mean += weight(i) * probes[i].point;
    weights += weight(i);
  }
  mean /= weights;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : chosen) {
    const Eigen::Vector3d offset = probes[i].point - mean;
    scatter += weight(i) * offset * offset.transpose();
  }
  return {mean, eigen_decomposition(scatter).eigenvectors().col(0)};
}

}  // namespace

double plane_tolerance(double stddev, double spacing) {
  return kNoiseDeviations * stddev + kSpacings * spacing;
}

// pcl::SACSegmentation takes twelve times as long for it, 74 ms a view, and prints.
PlanarPart largest_plane(const std::vector<PlaneProbe>& probes) {
  PlanarPart largest;
  for (std::size_t seed = 0; seed < std::min(kSeeds, probes.size()); ++seed) {
    Plane plane{probes[seed].point, probes[seed].normal};
    double reach = kFirstTolerance;
    auto face = near(plane, probes, reach);
    for (int fit = 0; fit < kFits && face.size() >= 3; ++fit) {
      plane = fitted(probes, face);
      reach = std::max(1.0, 0.5 * reach);
      face = near(plane, probes, reach);
    }
    if (face.size() > largest.probes.size()) largest = {std::move(face), plane.point, plane.normal};
  }
  return largest;
}

}  // namespace relief::registration
