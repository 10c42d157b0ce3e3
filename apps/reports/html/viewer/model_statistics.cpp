#include "apps/reports/html/viewer/model_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "scan/base/disjoint_sets.h"

namespace relief {

namespace {

bool is_filled(const TriangleMesh& mesh, std::size_t vertex) {
  return !mesh.filled.empty() && mesh.filled[vertex] != 0;
}

Histogram error_histogram(const std::vector<float>& errors, double high) {
  constexpr std::size_t kBins = 40;
  Histogram histogram{0.0, high, std::vector<std::size_t>(kBins)};
  for (const float error : errors) {
    const double bin = kBins * (high > 0.0 ? error / high : 0.0);
    ++histogram.counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
  }
  return histogram;
}

void measure_errors(const TriangleMesh& mesh, ModelStatistics& statistics) {
  std::vector<float> errors = measured_errors(mesh);
  if (errors.empty()) return;
  statistics.median_error = quantile(errors, 0.5);
  statistics.error_p95 = quantile(errors, 0.95);
  statistics.expected_error = error_histogram(errors, quantile(errors, 0.99));
}

void count_views(const TriangleMesh& mesh, ModelStatistics& statistics) {
  for (std::size_t v = 0; v < mesh.views.size(); ++v) {
    const std::size_t views = is_filled(mesh, v) ? 0 : mesh.views[v];
    if (statistics.vertices_by_views.size() <= views)
      statistics.vertices_by_views.resize(views + 1);
    ++statistics.vertices_by_views[views];
  }
}

// Faces all of whose corners are filled, joined along common vertices.
class RegionFinder {
 public:
  explicit RegionFinder(const TriangleMesh& mesh) : mesh_(mesh), sets_(mesh.vertices.size()) {}

  std::vector<FilledRegion> operator()() {
    for (const TriangleMesh::Face& face : mesh_.faces)
      if (all_filled(face))
        for (const std::uint32_t vertex : face) sets_.join(face[0], vertex);
    std::map<std::uint32_t, FilledRegion> regions;
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f)
      if (all_filled(mesh_.faces[f])) add(f, regions[sets_.find(mesh_.faces[f][0])]);
    return sorted(regions);
  }

 private:
  bool all_filled(const TriangleMesh::Face& face) const {
    return std::all_of(face.begin(), face.end(), [this](auto v) { return is_filled(mesh_, v); });
  }

  void add(std::size_t f, FilledRegion& region) const {
    const Eigen::Vector3d cross = face_cross(mesh_, f);
    const double area = 0.5 * cross.norm();
    region.area += area;
    region.outward += 0.5 * cross;
    region.centre += area / 3.0 * (mesh_.corner(f, 0) + mesh_.corner(f, 1) + mesh_.corner(f, 2));
  }

  static std::vector<FilledRegion> sorted(const std::map<std::uint32_t, FilledRegion>& regions) {
    std::vector<FilledRegion> list;
    for (const auto& [vertex, region] : regions)
      if (region.area > 0.0)
        list.push_back({region.area, region.centre / region.area, region.outward / region.area});
    std::stable_sort(list.begin(), list.end(),
                     [](const auto& a, const auto& b) { return a.area > b.area; });
    return list;
  }

  const TriangleMesh& mesh_;
  DisjointSets sets_;
};

}  // namespace

std::vector<float> measured_errors(const TriangleMesh& mesh) {
  std::vector<float> errors;
  for (std::size_t v = 0; v < mesh.quality.size(); ++v)
    if (!is_filled(mesh, v) && std::isfinite(mesh.quality[v])) errors.push_back(mesh.quality[v]);
  return errors;
}

float quantile(std::vector<float>& values, double fraction) {
  const auto place =
      values.begin() + std::lround(fraction * (static_cast<double>(values.size()) - 1.0));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

ModelStatistics measure_model(const TriangleMesh& mesh) {
  ModelStatistics statistics;
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  statistics.low = box.min();
  statistics.high = box.max();
  statistics.area = surface_area(mesh);
  measure_errors(mesh, statistics);
  count_views(mesh, statistics);
  if (!mesh.filled.empty()) statistics.regions = RegionFinder(mesh)();
  return statistics;
}

}  // namespace relief
