#include "fusion/holes/fair_regions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "fusion/holes/filled_regions.h"
#include "fusion/holes/rest_curvature.h"
#include "fusion/tsdf/tsdf_integration.h"
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

// Rings of measured vertices round the filled ones that move with them. Those of the third follow
// what was measured from waves of 2 pi / 4 voxels on: almost to the voxel.
constexpr int kMargin = 3;

// Rings of measured vertices beyond these that tell how the surface curves towards the border.
constexpr int kApproach = 6;

// A surface that, as it curves, turns by less than this part of what the filled one has to has an
// edge at its border. By (F8) a block turns by 0, a sphere by 69 of 89 degrees: 0.1 to 0.7 will do.
constexpr double kCarried = 0.5;

// One that turns by more than this part of it, along the way that it has across a sphere, goes on
// as it arrives: between a block's 0 and a sphere's 1, nearer to the latter.
constexpr double kRound = 0.75;

// Of that angle: a sphere of which less than a thirtieth was seen is none that anybody knows.
constexpr double kLeastSine = 0.25;

// Edges from what was measured from which on the closed field has the curvature of the surface.
constexpr int kDeep = 8;

// Of each vertex the number of edges to the nearest one with `set`, at most `most` + 1.
std::vector<std::uint8_t> rings_around(const TriangleMesh& mesh,
                                       const std::vector<std::uint8_t>& set, int most) {
  std::vector<std::uint8_t> rings(mesh.vertices.size());
  for (std::size_t v = 0; v < rings.size(); ++v)
    rings[v] = set[v] ? 0 : static_cast<std::uint8_t>(most + 1);
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

double attraction_of(int ring, double voxel) { return std::pow(std::ldexp(voxel, 1 - ring), -4); }

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
      rings_(rings_around(mesh, mesh.filled, kMargin + 1 + kApproach)),
      around_(mesh, up_to(kMargin + kApproach, rings_)),
      region_of_(mesh.vertices.size(), kNone),
      regions_(find(options.most_solved)),
      normals_(mesh, near_regions(), options.memory) {
  parallel_for(regions_.size(), 1, [&](std::size_t begin, std::size_t end) {
    evict_pages(options.memory);
    for (std::size_t r = begin; r < end; ++r) prepare(regions_[r], views, options);
  });
}

std::vector<FairRegion> FairRegions::find(std::size_t most_solved) {
  const std::vector<std::uint32_t> first = regions_of(mesh_, up_to(kMargin, rings_));
  std::vector<std::uint32_t> sizes(first.size(), 0);
  for (const std::uint32_t region : first) ++sizes[region];
  std::map<std::uint32_t, FairRegion> candidates;
  for (std::uint32_t v = 0; v < first.size(); ++v) {
    if (rings_[v] > kMargin) continue;
    FairRegion& region = candidates[first[v]];
    region.vertices.reserve(sizes[first[v]]);
    region.vertices.push_back({v, mesh_.vertices[v]});
  }
  std::vector<FairRegion> found;
  for (auto& [start, region] : candidates) {
    add_border(region);
    if (region.border.empty() || !is_deep(region) || is_crevice(region)) continue;
    if (region.vertices.size() > most_solved) {
      ++too_large_;
      continue;
    }
    for (const PlateVertex& free : region.vertices)
      region_of_[free.vertex] = static_cast<std::uint32_t>(found.size());
    found.push_back(std::move(region));
  }
  return found;
}

// The vertices whose faces the normals in the regions depend on. Those of faces of the last ring
// are an edge farther.
std::vector<std::uint8_t> FairRegions::near_regions() const {
  std::vector<std::uint8_t> near(region_of_.size());
  for (std::size_t v = 0; v < near.size(); ++v) near[v] = region_of_[v] != kNone;
  near = up_to(SideNormals::kReach + 1, rings_around(mesh_, near, SideNormals::kReach + 1));
  for (std::size_t v = 0; v < near.size(); ++v) near[v] = near[v] && rings_[v] <= kMargin + 1;
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
        if (rings_[w] > kMargin) border.push_back(w);
    });
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  for (const std::uint32_t v : border) region.border.push_back({v, mesh_.vertices[v]});
}

// How far the middle of a region lies behind the tangent planes of its border, on average, against
// its distance: negative in a valley.
double FairRegions::behind_border(const FairRegion& region) const {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PlateVertex& free : region.vertices) centre += mesh_.vertices[free.vertex];
  centre /= static_cast<double>(region.vertices.size());
  double behind = 0.0, away = 0.0;
  for (const PlateVertex& held : region.border) {
    const Eigen::Vector3d to_centre = centre - held.place;
    behind -= to_centre.dot(mesh_.normals[held.vertex].cast<double>());
    away += to_centre.norm();
  }
  return behind / away;
}

// Whether a region lies in a narrow valley. There the closed field knows both walls; a plate would
// go on with their slopes and dig deep.
bool FairRegions::is_crevice(const FairRegion& region) const {
  const auto filled = static_cast<double>(
      std::count_if(region.vertices.begin(), region.vertices.end(),
                    [&](const PlateVertex& free) { return mesh_.filled[free.vertex] != 0; }));
  return behind_border(region) < -kAheadOfSurface &&
         2.0 * filled < kNarrow * static_cast<double>(region.border.size());
}

// Mean distance of a border from its centre [unit].
double FairRegions::half_width(const FairRegion& region) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PlateVertex& held : region.border) centre += held.place;
  centre /= static_cast<double>(region.border.size());
  double sum = 0.0;
  for (const PlateVertex& held : region.border) sum += (held.place - centre).norm();
  return sum / static_cast<double>(region.border.size());
}

// How the surface arrives at a region's border, and has to turn across it.
FairRegions::Arrival FairRegions::arrival_at(const FairRegion& region, double voxel) const {
  Arrival arrival;
  double area = 0.0;  // Of the filled faces, six times.
  for (const PlateVertex& free : region.vertices) {
    if (!mesh_.filled[free.vertex]) continue;
    around_.visit(free.vertex, [&](std::uint32_t f) {
      arrival.facing += face_cross(mesh_, f);
      area += face_cross(mesh_, f).norm();
    });
  }
  arrival.facing.normalize();
  const auto mean_turn = [&](const std::vector<std::uint32_t>& ring) {
    double sum = 0.0;
    for (const std::uint32_t v : ring)
      sum += std::acos(std::clamp(mesh_.normals[v].cast<double>().dot(arrival.facing), -1.0, 1.0));
    return sum / static_cast<double>(ring.size());
  };
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& held : region.border) ring.push_back(held.vertex);
  arrival.turn = mean_turn(ring);
  for (int k = 0; k < kApproach && !ring.empty(); ++k) ring = ring_beyond(ring);
  if (ring.empty()) return arrival;
  const double rate = (mean_turn(ring) - arrival.turn) / (kApproach * voxel);
  const double half_way = std::sqrt(area / (6.0 * std::numbers::pi));
  arrival.carried = rate * half_way;  // Equation (F8).
  arrival.on_sphere = rate * std::min(half_way, half_width(region)) * arrival.turn /
                      std::max(std::sin(arrival.turn), kLeastSine);
  arrival.known = true;
  return arrival;
}

void FairRegions::add_approach(FairRegion& region) const {
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& held : region.border) ring.push_back(held.vertex);
  for (int k = 1; k < kApproach; ++k) {
    ring = ring_beyond(ring);
    region.approach.insert(region.approach.end(), ring.begin(), ring.end());
  }
}

// The vertices beside those of a ring that are one edge farther from what was filled.
std::vector<std::uint32_t> FairRegions::ring_beyond(const std::vector<std::uint32_t>& ring) const {
  std::vector<std::uint32_t> next;
  for (const std::uint32_t v : ring)
    around_.visit(v, [&](std::uint32_t f) {
      for (const std::uint32_t w : mesh_.faces[f])
        if (rings_[w] == rings_[v] + 1) next.push_back(w);
    });
  std::sort(next.begin(), next.end());
  next.erase(std::unique(next.begin(), next.end()), next.end());
  return next;
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
  const double behind = behind_border(region);
  const Arrival arrival = behind > kCurved ? arrival_at(region, options.voxel_size) : Arrival();
  region.curved =
      seen_from_one_side(views) && arrival.known && arrival.on_sphere >= kRound * arrival.turn;
  const bool ends_walls = arrival.known && !region.curved && behind > kBehind &&
                          arrival.turn > std::acos(kSharp) &&
                          arrival.carried < kCarried * arrival.turn;
  const Eigen::Vector3d lid = ends_walls ? arrival.facing : Eigen::Vector3d::Zero();
  if (region.curved) add_approach(region);
  for (PlateVertex& free : region.vertices) {
    const int ring = rings_[free.vertex];
    if (ring == 0) {
      // The wall goes on as far as the closed field has it before the lid begins.
      if (lid.isZero() || !is_beside_measured(free.vertex)) continue;
      free.attraction = attraction_of(1, options.voxel_size);
      free.stiffness = 0.0;
      continue;
    }
    // Beside what is filled the closed field draws the surface off what was measured.
    const Eigen::Vector3d normal = mesh_.normals[free.vertex].cast<double>();
    free.place -= collector.collect(free.place, normal).distance * normal;
    free.attraction = attraction_of(ring, options.voxel_size);
    if (ring != 1) continue;
    double cosine = normals_.cosine(free.vertex, around_);
    if (!lid.isZero()) cosine = std::min(cosine, lid.dot(normals_.at(free.vertex)));
    free.stiffness = stiffness_of(cosine);
  }
  if (region.curved) set_rest(region, options.voxel_size);
}

// Where the filled surface is far from what was measured it rests as it is; near by it rests as
// its surroundings do.
void FairRegions::set_rest(FairRegion& region, double voxel) const {
  const std::vector<std::uint32_t> vertices = region.with_approach();
  const std::unordered_map<std::uint32_t, int> depths = depths_in(region);
  std::vector<std::uint8_t> known;
  for (const std::uint32_t v : vertices) {
    const auto depth = depths.find(v);
    known.push_back(rings_[v] > kMargin || (depth != depths.end() && depth->second > kDeep));
  }
  bend_to(mesh_, around_, continued_curvature(mesh_, around_, vertices, known, voxel), region);
}

// Edges from what was measured of the filled vertices of a region that are farther than kDeep are
// kDeep + 1.
std::unordered_map<std::uint32_t, int> FairRegions::depths_in(const FairRegion& region) const {
  std::unordered_map<std::uint32_t, int> depths;
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& free : region.vertices) {
    if (rings_[free.vertex] == 0)
      depths.emplace(free.vertex, kDeep + 1);
    else if (rings_[free.vertex] == 1)
      ring.push_back(free.vertex);
  }
  for (int depth = 1; depth <= kDeep; ++depth) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t v : ring)
      around_.visit(v, [&](std::uint32_t f) {
        for (const std::uint32_t w : mesh_.faces[f]) {
          const auto found = depths.find(w);
          if (found == depths.end() || found->second <= kDeep) continue;
          found->second = depth;
          next.push_back(w);
        }
      });
    ring = std::move(next);
  }
  return depths;
}

}  // namespace relief::fusion
