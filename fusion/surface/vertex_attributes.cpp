#include "fusion/surface/vertex_attributes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "fusion/surface/vertex_groups.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// How many measurements the view noise counts for against a vertex's own scatter, (F6): as many as
// four views. The variance of two views then scatters by sqrt(2) / 4 = 35 %, without it by 141.
constexpr double kPriorWeight = 3.0;

float standard_error(const TsdfSample& evidence, const VertexAttributeOptions& options) {
  const double own = std::max(0.0, evidence.effective_views - 1.0);
  // Of the mean, by what the views know of their errors.
  const double known = options.nominal_deviation > 0.0
                           ? std::pow(options.nominal_deviation, 2) / evidence.information
                           : std::pow(options.view_stddev, 2) * evidence.relative_variance;
  return static_cast<float>(
      std::sqrt((kPriorWeight * known + evidence.variance) / (kPriorWeight + own)));
}

}  // namespace

void set_vertex_attributes(TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                           const VertexAttributeOptions& options) {
  const std::size_t count = mesh.vertices.size();
  mesh.normals = vertex_normals(mesh);
  mesh.views.assign(count, 0);
  mesh.source_views.assign(options.view_indices.empty() ? 0 : count, kNoSourceView);
  mesh.filled.assign(count, 0);
  mesh.quality.assign(count, 0.0f);
  parallel_for(count, 1024, [&](std::size_t begin, std::size_t end) {
    evict_pages(options.memory);
    TsdfIntegrator collector(views, options.truncation, options.voxel_size);
    visit_in_groups(mesh, begin, end, collector, [&](std::size_t v) {
      const TsdfSample evidence =
          collector.collect(mesh.vertices[v], mesh.normals[v].cast<double>());
      mesh.filled[v] = !evidence.measured || std::abs(evidence.distance) > 0.5 * options.voxel_size;
      if (mesh.filled[v]) return;
      mesh.views[v] = static_cast<std::uint16_t>(std::min(evidence.views, 65535));
      if (const auto view = collector.strongest_view(); view && !mesh.source_views.empty())
        mesh.source_views[v] = options.view_indices[*view];
      mesh.quality[v] = standard_error(evidence, options);
    });
  });
}

void set_filled_quality(TriangleMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> beside(mesh.vertices.size());
  for (const auto& face : mesh.faces)
    for (std::size_t k = 0; k < 3; ++k)
      if (mesh.filled[face[(k + 1) % 3]]) beside[face[k]].push_back(face[(k + 1) % 3]);
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<double> distance(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.filled[v]) continue;
    distance[v] = 0.0;
    if (!beside[v].empty()) queue.emplace(0.0, v);
  }
  while (!queue.empty()) {
    const auto [so_far, v] = queue.top();
    queue.pop();
    if (so_far > distance[v]) continue;
    for (const std::uint32_t next : beside[v]) {
      const double through = so_far + (mesh.vertices[next] - mesh.vertices[v]).norm();
      if (through >= distance[next]) continue;
      distance[next] = through;
      queue.emplace(through, next);
    }
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.filled[v]) mesh.quality[v] = static_cast<float>(distance[v]);
}

}  // namespace relief::fusion
