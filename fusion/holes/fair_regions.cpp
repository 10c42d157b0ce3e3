#include "fusion/holes/fair_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>
#include <utility>

#include "fusion/holes/border_bend.h"
#include "fusion/holes/filled_regions.h"
#include "fusion/holes/rest_curvature.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Cosines at a border between the measured surface and that of the closed field: below 30 degrees
// the surface goes on, above 60 the object has an edge. Thirds of the 90 degrees of a block.
constexpr double kSmooth = 0.866, kSharp = 0.5;

// Sines at which the middle of a region lies against its border's tangent planes. So far behind
// (the cap of a sphere of half angle 30 degrees) it may be a lid, so far in front (3) a crevice.
constexpr double kBehind = 0.5, kAheadOfSurface = 0.05;

// And here it curves: one step of a plate is off by about the cube of the angle over 8, for 15
// degrees 0.2 % of the region's half width.
constexpr double kCurved = 0.25;

// Twice the area of a crevice over the length of its border [vertices]: 16 across a strip, 32 a
// disc. With plates there the falcon is 0.143 off, not 0.115 (docs/results.md, Hole filling).
constexpr double kNarrow = 16.0;

// A surface that, as it curves, turns by less than this part of what the filled one has to has an
// edge at its border. By (F8) a block turns by 0, a sphere by 69 of 89 degrees: 0.1 to 0.7 will do.
constexpr double kCarried = 0.5;

// One that turns by more than this part of it, along the way that it has across a sphere, goes on
// as it arrives: between a block's 0 and a sphere's 1, nearer to the latter.
constexpr double kRound = 0.75;

// Of each vertex the number of edges to the nearest one with `set`, at most `most` + 1.
PagedArray<std::uint8_t> rings_around(const TriangleMesh& mesh, std::span<const std::uint8_t> set,
                                      int most) {
  PagedArray<std::uint8_t> rings(mesh.vertices.size());
  for (std::size_t v = 0; v < rings.size(); ++v)
    rings[v] = set[v] ? 0 : static_cast<std::uint8_t>(most + 1);
  for (int ring = 1; ring <= most; ++ring)
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      const auto& face = mesh.faces[f];
      if (std::none_of(face.begin(), face.end(), [&](auto v) { return rings[v] == ring - 1; }))
        return;
      for (const std::uint32_t v : face)
        rings[v] = std::min(rings[v], static_cast<std::uint8_t>(ring));
    });
  return rings;
}

PagedArray<std::uint8_t> up_to(int ring, const PagedArray<std::uint8_t>& rings) {
  PagedArray<std::uint8_t> flags(rings.size());
  for (std::size_t v = 0; v < flags.size(); ++v) flags[v] = rings[v] <= ring;
  return flags;
}

double stiffness_of(double cosine) {
  const double s = std::clamp((cosine - kSharp) / (kSmooth - kSharp), 0.0, 1.0);
  return s * s * s;
}

// A region most of which lies so near to what was measured inside of it takes its shape from there
// [edges]; a crevice with a few samples at its rim, or the base of a statue, does not.
constexpr int kNearSamples = 3;

// A scattered sample counts for a sixteenth of a vertex of the first ring: its noise is not
// averaged with that of others, and it may be a stray. In the middle of a hole 30 vertices across
// one alone moves a plate by a fifth of its distance; many together hold it.
constexpr int kScattered = 0;

double attraction_of(int ring, double voxel) { return std::pow(std::ldexp(voxel, 1 - ring), -4); }

bool is_island(const FairRegion& region, std::uint32_t vertex) {
  return std::binary_search(region.islands.begin(), region.islands.end(), vertex);
}

}  // namespace

std::vector<std::uint32_t> FairRegion::with_approach() const {
  std::vector<std::uint32_t> all;
  for (const PlateVertex& vertex : vertices) all.push_back(vertex.vertex);
  for (const PlateVertex& vertex : border) all.push_back(vertex.vertex);
  all.insert(all.end(), approach.begin(), approach.end());
  return all;
}

FairRegions::FairRegions(const TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                         const FairFillOptions& options)
    : mesh_(mesh),
      rings_(rings_around(mesh, mesh.filled, MeshRings::kMargin + 1 + kApproachRings)),
      around_(mesh, up_to(MeshRings::kMargin + kApproachRings, rings_)),
      scattered_(
          scattered_samples_at(mesh, up_to(MeshRings::kMargin, rings_), views, options.truncation)),
      region_of_(paged_filled(mesh.vertices.size(), kNone)),
      regions_(find(options)),
      normals_(mesh, near_regions()) {
  parallel_for(regions_.size(), 1, [&](std::size_t begin, std::size_t end) {
    evict_pages(options.memory);
    for (std::size_t r = begin; r < end; ++r) prepare(regions_[r], views, options);
  });
}

bool FairRegions::any_near_samples() const {
  return std::any_of(regions_.begin(), regions_.end(),
                     [](const FairRegion& region) { return region.near_samples; });
}

std::vector<FairRegion> FairRegions::find(const FairFillOptions& options) {
  const auto first = regions_of(mesh_, up_to(MeshRings::kMargin, rings_));
  PagedArray<std::uint32_t> sizes(first.size());
  for (const std::uint32_t region : first) ++sizes[region];
  std::map<std::uint32_t, FairRegion> candidates;
  for (std::uint32_t v = 0; v < first.size(); ++v) {
    if (rings_[v] > MeshRings::kMargin) continue;
    FairRegion& region = candidates[first[v]];
    region.vertices.reserve(sizes[first[v]]);
    region.vertices.push_back({v, mesh_.vertices[v]});
  }
  std::vector<FairRegion> found;
  for (auto& [start, region] : candidates) {
    add_border(region);
    if (region.border.empty() || !is_deep(region) || is_crevice(region)) continue;
    if (region.vertices.size() > options.most_solved) {
      ++too_large_;
      continue;
    }
    add_islands(first, region);
    region.near_samples = is_near_samples(region);
    if (options.near_samples_only && !region.near_samples) continue;
    for (const PlateVertex& free : region.vertices)
      region_of_[free.vertex] = static_cast<std::uint32_t>(found.size());
    found.push_back(std::move(region));
  }
  return found;
}

// The vertices whose faces the normals in the regions depend on. Those of faces of the last ring
// are an edge farther.
PagedArray<std::uint8_t> FairRegions::near_regions() const {
  PagedArray<std::uint8_t> near(region_of_.size());
  for (std::size_t v = 0; v < near.size(); ++v) near[v] = region_of_[v] != kNone;
  near = up_to(SideNormals::kReach + 1, rings_around(mesh_, near, SideNormals::kReach + 1));
  for (std::size_t v = 0; v < near.size(); ++v)
    near[v] = near[v] && rings_[v] <= MeshRings::kMargin + 1;
  return near;
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
        if (rings_[w] > MeshRings::kMargin) border.push_back(w);
    });
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  for (const std::uint32_t v : border) region.border.push_back({v, mesh_.vertices[v]});
}

// The measured vertices of the region that no way along measured ones of it leads to from the
// border, at which other regions may lie as well. `regions`: by vertex, see regions_of().
void FairRegions::add_islands(const PagedArray<std::uint32_t>& regions, FairRegion& region) const {
  const std::uint32_t own = regions[region.vertices.front().vertex];
  std::unordered_set<std::uint32_t> connected;
  std::vector<std::uint32_t> reached;
  for (const PlateVertex& vertex : region.border) reached.push_back(vertex.vertex);
  for (std::size_t next = 0; next < reached.size(); ++next)
    around_.visit(reached[next], [&](std::uint32_t f) {
      for (const std::uint32_t w : mesh_.faces[f])
        if (rings_[w] > 0 && rings_[w] <= MeshRings::kMargin && regions[w] == own &&
            connected.insert(w).second)
          reached.push_back(w);
    });
  for (const PlateVertex& free : region.vertices)
    if (rings_[free.vertex] > 0 && !connected.contains(free.vertex))
      region.islands.push_back(free.vertex);
  std::sort(region.islands.begin(), region.islands.end());
}

// Whether most filled vertices are near islands or scattered samples.
bool FairRegions::is_near_samples(const FairRegion& region) const {
  std::vector<std::uint32_t> samples = region.islands;
  for (const PlateVertex& free : region.vertices)
    if (scattered_.contains(free.vertex)) samples.push_back(free.vertex);
  const auto near = edges_from(std::move(samples), kNearSamples, mesh_, around_);
  std::size_t filled = 0, filled_near = 0;
  for (const PlateVertex& free : region.vertices) {
    if (!mesh_.filled[free.vertex]) continue;
    ++filled;
    filled_near += near.contains(free.vertex) ? 1 : 0;
  }
  return 2 * filled_near > filled;
}

// Whether a region lies in a narrow valley. There the closed field knows both walls; a plate would
// go on with their slopes and dig deep.
bool FairRegions::is_crevice(const FairRegion& region) const {
  const auto filled = static_cast<double>(
      std::count_if(region.vertices.begin(), region.vertices.end(),
                    [&](const PlateVertex& free) { return mesh_.filled[free.vertex] != 0; }));
  return behind_border(mesh_, region) < -kAheadOfSurface &&
         2.0 * filled < kNarrow * static_cast<double>(region.border.size());
}

bool FairRegions::is_beside_measured(std::uint32_t vertex) const {
  bool beside = false;
  around_.visit(vertex, [&](std::uint32_t f) {
    for (const std::uint32_t w : mesh_.faces[f]) beside = beside || rings_[w] == 1;
  });
  return beside;
}

void FairRegions::prepare(FairRegion& region, const std::vector<ViewSampler>& views,
                          const FairFillOptions& options) const {
  TsdfIntegrator collector(views, options.truncation, options.voxel_size);
  const double behind = behind_border(mesh_, region);
  const BorderBend bend =
      behind > kCurved ? bend_at_border(rings(), region, options.voxel_size) : BorderBend();
  region.curved = seen_from_one_side(views) && bend.known && bend.on_sphere >= kRound * bend.turn;
  const bool ends_walls = bend.known && !region.curved && behind > kBehind &&
                          bend.turn > std::acos(kSharp) && bend.carried < kCarried * bend.turn;
  const Eigen::Vector3d lid = ends_walls ? bend.facing : Eigen::Vector3d::Zero();
  if (region.curved) add_approach(rings(), region);
  for (PlateVertex& free : region.vertices) {
    const int ring = rings_[free.vertex];
    if (ring == 0) {
      // The wall goes on as far as the closed field has it before the lid begins.
      if (!lid.isZero() && is_beside_measured(free.vertex)) {
        free.attraction = attraction_of(1, options.voxel_size);
        free.stiffness = 0.0;
      } else if (const auto found = scattered_.find(free.vertex); found != scattered_.end()) {
        free.place += found->second.offset * mesh_.normals[free.vertex].cast<double>();
        free.attraction = found->second.weight * attraction_of(kScattered, options.voxel_size);
      }
      continue;
    }
    // Beside what is filled the closed field draws the surface off what was measured.
    const Eigen::Vector3d normal = mesh_.normals[free.vertex].cast<double>();
    free.place -= collector.collect(free.place, normal).distance * normal;
    free.attraction = attraction_of(ring, options.voxel_size);
    if (ring != 1 || is_island(region, free.vertex)) continue;
    double cosine = normals_.cosine(free.vertex, around_);
    if (!lid.isZero()) cosine = std::min(cosine, lid.dot(normals_.at(free.vertex)));
    free.stiffness = stiffness_of(cosine);
  }
  if (region.curved) set_rest_curvature(rings(), options.voxel_size, region);
}

}  // namespace relief::fusion
