#include "fusion/surface/vertex_attributes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "fusion/holes/plates/cotangent_laplacian.h"
#include "fusion/surface/vertex_groups.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// How many measurements the view noise counts for against a vertex's own scatter, (F6): as many as
// four views. The variance of two views then scatters by sqrt(2) / 4 = 35 %, without it by 141.
constexpr double kPriorWeight = 3.0;

constexpr std::size_t kBetweenStops = 4096;  // Vertices between two looks; changes no result.

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
  mesh.views = paged_filled<std::uint16_t>(count, 0);
  mesh.source_views = paged_filled(options.view_indices.empty() ? 0 : count, kNoSourceView);
  mesh.filled = paged_filled<std::uint8_t>(count, 0);
  mesh.quality = paged_filled(count, 0.0f);
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

// Dijkstra's algorithm from the measured vertices beside filled ones.
void set_filled_quality(TriangleMesh& mesh) {
  const FacesAround around(mesh, mesh.filled);  // Measured vertices are not reached.
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  auto distance = paged_filled(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  const auto reach = [&](std::uint32_t v, std::uint32_t from, double so_far) {
    const double through = so_far + (mesh.vertices[v] - mesh.vertices[from]).norm();
    if (through >= distance[v]) return;
    distance[v] = through;
    queue.emplace(through, v);
  };
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (const std::uint32_t from : mesh.faces[f])
      for (const std::uint32_t v : mesh.faces[f])
        if (mesh.filled[v] && !mesh.filled[from]) reach(v, from, 0.0);
  });
  for (std::size_t step = 0; !queue.empty(); ++step) {
    if (step % kBetweenStops == 0) check_stop_and_memory();
    const auto [so_far, from] = queue.top();
    queue.pop();
    if (so_far > distance[from]) continue;
    around.visit(from, [&, so_far = so_far, from = from](std::uint32_t f) {
      for (const std::uint32_t v : mesh.faces[f])
        if (v != from && mesh.filled[v]) reach(v, from, so_far);
    });
  }
  serial_for(mesh.vertices.size(), [&](std::size_t v) {
    if (mesh.filled[v]) mesh.quality[v] = static_cast<float>(distance[v]);
  });
}

}  // namespace relief::fusion
