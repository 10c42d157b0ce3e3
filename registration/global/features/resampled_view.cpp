#include "registration/global/features/resampled_view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <utility>

#include "registration/pairwise/robust.h"
#include "scan/base/cell_key.h"

namespace relief::registration {

namespace {

// Of a typical view, 36 x 36: large features, 6 cells, reach a third of its half width. Half or
// twice as many make features 1.4 times as large or small; the time grows with them.
constexpr double kCells = 1300.0;
// Side of a cell [sample spacings]: nine samples and more to a cell.
constexpr double kLeastSpacings = 3.0;
// Bounds the time: the rank of a quantile of 0.9 is good to 0.7 %.
constexpr std::size_t kRadiusProbes = 2000;
// Bounds the time: 46 for each of kCells reduce the noise of a mean to a seventh.
constexpr std::size_t kMostSamples = 60000;
// Length of a mean of normals, 1 when all agree: (1 + cos a) / 2 when they fill a cone of half
// angle a, here 53 degrees. Cells across an edge are left out; see resample() for what that gains.
constexpr double kLeastMeanNormal = 0.8;

// Without the farthest samples, which may be strays.
double robust_radius(const ViewSurface& surface) {
  const std::size_t count = std::min(kRadiusProbes, surface.samples().size());
  std::vector<double> distances;
  for (std::size_t i = 0; i < count; ++i)
    distances.push_back((surface.sample(surface.samples()[i]).point - surface.centre()).norm());
  return quantile(std::move(distances), 0.9);
}

std::uint64_t cell_of(const Eigen::Vector3d& offset, double cell) {
  constexpr std::int64_t kHalf = 1 << 20;  // Of the 21 bits that a key has for each direction.
  const auto index = (offset / cell).array().floor().max(-1e6).min(1e6).cast<std::int64_t>().eval();
  return cell_key(index.z() + kHalf, index.y() + kHalf, index.x() + kHalf);
}

}  // namespace

CoarseScale coarse_scale(const std::vector<ViewSurface>& surfaces) {
  std::vector<double> radii, spacings, areas;
  for (const auto& surface : surfaces) {
    if (surface.samples().empty()) continue;
    radii.push_back(robust_radius(surface));
    spacings.push_back(surface.spacing());
    areas.push_back(static_cast<double>(surface.samples().size()) * surface.spacing() *
                    surface.spacing());
  }
  CoarseScale scale;
  scale.radius = quantile(std::move(radii), 0.5);
  scale.cell = std::max(std::sqrt(quantile(std::move(areas), 0.5) / kCells),
                        kLeastSpacings * quantile(std::move(spacings), 0.5));
  return scale;
}

// pcl::VoxelGrid keeps cells whose normals disagree, and 1.3 % fewer matches between views of the
// Stanford bunny are true.
ResampledView resample(const ViewSurface& surface, double cell) {
  assert(cell > 0.0);
  const std::size_t count = std::min(kMostSamples, surface.samples().size());
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t index = surface.samples()[i];
    keyed[i] = {cell_of(surface.sample(index).point - surface.centre(), cell), index};
  }
  std::sort(keyed.begin(), keyed.end());

  std::vector<Eigen::Vector3d> points, normals;
  for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
    Eigen::Vector3d offset = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    for (end = begin; end < count && keyed[end].first == keyed[begin].first; ++end) {
      const SurfacePoint sample = surface.sample(keyed[end].second);
      offset += sample.point - surface.centre();
      normal += sample.normal;
    }
    const double samples = static_cast<double>(end - begin);
    if (normal.norm() < kLeastMeanNormal * samples) continue;
    points.push_back(surface.centre() + offset / samples);
    normals.push_back(normal.normalized());
  }
  ResampledView view;
  view.points.resize(3, static_cast<Eigen::Index>(points.size()));
  view.normals.resizeLike(view.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    view.points.col(static_cast<Eigen::Index>(i)) = points[i];
    view.normals.col(static_cast<Eigen::Index>(i)) = normals[i];
  }
  return view;
}

}  // namespace relief::registration
