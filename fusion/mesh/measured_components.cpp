#include "fusion/mesh/measured_components.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "scan/base/cell_key.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Of the samples: a component with more of them is no stray.
constexpr double kReal = 0.05;

// Samples that are looked at, at most. They tell a twentieth to 0.2 % of all.
constexpr std::size_t kMostSamples = 20000;

// Every n-th sample of the views, so that each view counts by its samples.
std::vector<Eigen::Vector3d> spread_samples(const std::vector<ViewSampler>& views) {
  std::size_t all = 0;
  for (const ViewSampler& view : views) view.for_surface_points([&](const auto&) { ++all; });
  const std::size_t stride = all / kMostSamples + 1;
  std::vector<Eigen::Vector3d> samples;
  std::size_t index = 0;
  for (const ViewSampler& view : views)
    view.for_surface_points([&](const Eigen::Vector3d& sample) {
      if (index++ % stride == 0) samples.push_back(sample);
    });
  return samples;
}

// The nearest vertex within `reach` of each sample, found in one pass over the vertices.
class NearestVertices {
 public:
  NearestVertices(std::vector<Eigen::Vector3d> samples, double reach)
      : samples_(std::move(samples)), reach_(reach), nearest_(samples_.size()) {
    for (std::size_t i = 0; i < samples_.size(); ++i)
      for (int k = 0; k < 27; ++k) {
        const Cell neighbour(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        near_[key_of(cell_of(samples_[i]) + neighbour)].push_back(i);
      }
  }

  void offer(std::uint32_t vertex, const Eigen::Vector3d& place) {
    const auto near = near_.find(key_of(cell_of(place)));
    if (near == near_.end()) return;
    for (const std::size_t i : near->second) {
      const double distance = (place - samples_[i]).squaredNorm();
      if (distance < nearest_[i].squared_distance && distance <= reach_ * reach_)
        nearest_[i] = {distance, vertex};
    }
  }

  // Calls visit(vertex) for each sample that has one.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (const Nearest& nearest : nearest_)
      if (std::isfinite(nearest.squared_distance)) visit(nearest.vertex);
  }

 private:
  using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
  struct Nearest {
    double squared_distance = std::numeric_limits<double>::infinity();
    std::uint32_t vertex = 0;
  };

  Cell cell_of(const Eigen::Vector3d& place) const {
    const Eigen::Vector3d cell = ((place - samples_.front()) / reach_).array().floor();
    return cell.cast<std::int64_t>();
  }
  static std::uint64_t key_of(const Cell& cell) { return cell_key(cell.x(), cell.y(), cell.z()); }

  std::vector<Eigen::Vector3d> samples_;
  double reach_;
  std::vector<Nearest> nearest_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> near_;  // Cells round samples.
};

std::vector<std::size_t> samples_on(const MeshComponents& components,
                                    const std::vector<ViewSampler>& views, double reach,
                                    const TriangleMesh& mesh) {
  std::vector<std::size_t> counts(components.count(), 0);
  std::vector<Eigen::Vector3d> samples = spread_samples(views);
  if (samples.empty()) return counts;
  NearestVertices nearest(std::move(samples), reach);
  serial_for(mesh.vertices.size(), [&](std::size_t v) {
    nearest.offer(static_cast<std::uint32_t>(v), mesh.vertices[v]);
  });
  nearest.for_each([&](std::uint32_t v) { ++counts[components.of_vertex[v]]; });
  return counts;
}

}  // namespace

MeasuredComponents keep_measured_components(const std::vector<ViewSampler>& views, double reach,
                                            TriangleMesh& mesh) {
  const MeshComponents components = find_components(mesh);
  MeasuredComponents result;
  result.kept = components.count();
  if (components.count() <= 1) return result;
  const std::vector<std::size_t> counts = samples_on(components, views, reach, mesh);
  const auto all =
      static_cast<double>(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  std::vector<bool> kept(components.count());
  // Of as many samples the larger one.
  std::size_t most = 0;
  for (std::size_t c = 0; c < kept.size(); ++c) {
    kept[c] = static_cast<double>(counts[c]) > kReal * all;
    if (std::pair(counts[c], components.area[c]) > std::pair(counts[most], components.area[most]))
      most = c;
  }
  kept[most] = true;
  for (std::size_t c = 0; c < kept.size(); ++c)
    if (!kept[c]) result.removed_samples += static_cast<double>(counts[c]) / std::max(1.0, all);
  result.removed = keep_components(components, kept, mesh);
  result.kept -= result.removed.components;
  return result;
}

}  // namespace relief::fusion
