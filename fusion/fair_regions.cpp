#include "fusion/fair_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "fusion/evidence.h"
#include "fusion/filled_regions.h"
#include "scan/parallel.h"

namespace relief {

namespace {

// Between the surface that was measured and that of the closed field, at a common border: with less
// than 30 degrees the surface goes on, with more than 60 the object has an edge.
constexpr double kSmooth = 0.866, kSharp = 0.5;

// Rings of measured vertices round the filled ones that move with them.
constexpr int kMargin = 3;

// Of each vertex the number of edges to the nearest filled one, at most `most` + 1.
std::vector<std::uint8_t> rings_around_filled(const TriangleMesh& mesh, int most) {
  std::vector<std::uint8_t> rings(mesh.vertices.size());
  for (std::size_t v = 0; v < rings.size(); ++v)
    rings[v] = mesh.filled[v] ? 0 : static_cast<std::uint8_t>(most + 1);
  for (int ring = 1; ring <= most; ++ring)
    for (const auto& face : mesh.faces) {
      if (std::none_of(face.begin(), face.end(), [&](auto v) { return rings[v] == ring - 1; }))
        continue;
      for (const std::uint32_t v : face)
        rings[v] = std::min(rings[v], static_cast<std::uint8_t>(ring));
    }
  return rings;
}

std::vector<std::uint8_t> up_to(int ring, const std::vector<std::uint8_t>& rings) {
  std::vector<std::uint8_t> flags(rings.size());
  for (std::size_t v = 0; v < flags.size(); ++v) flags[v] = rings[v] <= ring;
  return flags;
}

double stiffness_of(double cosine) {
  const double s = std::clamp((cosine - kSharp) / (kSmooth - kSharp), 0.0, 1.0);
  return s * s * s;
}

double pull_of(int ring, double voxel) { return std::pow(std::ldexp(voxel, 1 - ring), -4); }

}  // namespace

FairRegions::FairRegions(const TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                         const FairFillOptions& options)
    : mesh_(mesh),
      rings_(rings_around_filled(mesh, kMargin + 2)),
      around_(mesh, up_to(kMargin + 1, rings_)),
      normals_(mesh, rings_, kMargin + 1) {
  find(options);
  parallel_for(regions_.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    relieve(options.memory);
    for (std::size_t r = begin; r < end; ++r) prepare(regions_[r], views, options);
  });
}

void FairRegions::find(const FairFillOptions& options) {
  const std::vector<std::uint32_t> first = regions_of(mesh_, up_to(kMargin, rings_));
  std::map<std::uint32_t, FairRegion> candidates;
  for (std::uint32_t v = 0; v < first.size(); ++v)
    if (rings_[v] <= kMargin) candidates[first[v]].vertices.push_back({v, mesh_.vertices[v]});
  region_of_.assign(first.size(), kNone);
  for (auto& [start, region] : candidates) {
    add_border(region);
    if (region.border.empty() || !is_deep(region)) continue;
    if (region.vertices.size() > options.largest_region) {
      ++too_large_;
      continue;
    }
    for (const PlateVertex& free : region.vertices)
      region_of_[free.vertex] = static_cast<std::uint32_t>(regions_.size());
    regions_.push_back(std::move(region));
  }
}

// Whether the region has a filled vertex among filled ones only. Else there is no shape to find.
bool FairRegions::is_deep(const FairRegion& region) const {
  return std::any_of(region.vertices.begin(), region.vertices.end(), [&](const PlateVertex& free) {
    bool deep = mesh_.filled[free.vertex];
    around_.visit(free.vertex, [&](std::uint32_t f) {
      for (const std::uint32_t w : mesh_.faces[f]) deep = deep && mesh_.filled[w];
    });
    return deep;
  });
}

void FairRegions::add_border(FairRegion& region) const {
  std::vector<std::uint32_t> border;
  for (const PlateVertex& free : region.vertices)
    around_.visit(free.vertex, [&](std::uint32_t f) {
      for (const std::uint32_t w : mesh_.faces[f])
        if (rings_[w] > kMargin) border.push_back(w);
    });
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  for (const std::uint32_t v : border) region.border.push_back({v, mesh_.vertices[v]});
}

void FairRegions::prepare(FairRegion& region, const std::vector<ViewSampler>& views,
                          const FairFillOptions& options) const {
  EvidenceCollector collector(views, options.truncation, options.voxel_size);
  for (PlateVertex& free : region.vertices) {
    const int ring = rings_[free.vertex];
    if (ring == 0) continue;
    // Beside what is filled the closed field draws the surface off what was measured.
    const Eigen::Vector3d normal = mesh_.normals[free.vertex].cast<double>();
    free.place -= collector.collect(free.place, normal).distance * normal;
    free.pull = pull_of(ring, options.voxel_size);
    if (ring == 1) free.stiffness = stiffness_of(normals_.cosine(free.vertex, around_));
  }
}

}  // namespace relief
