#include "fusion/holes/bent_regions.h"

#include <algorithm>
#include <utility>

#include "fusion/holes/plates/thin_plate.h"
#include "fusion/holes/rest_curvature.h"

namespace relief::fusion {

namespace {

// Steps on one mesh. Later ones stretch its faces: then a new mesh is better.
constexpr int kSteps = 8;

// A step that moves no vertex farther ends the bending [edges].
constexpr double kAtRest = 0.05;

class Bending {
 public:
  Bending(TriangleMesh& mesh, const FairRegions& regions, const FairFillOptions& options)
      : mesh_(mesh), regions_(regions), options_(options) {}

  // The farthest that a step moved a vertex; 0 where no plate was found.
  double bend(const FairRegion& region) {
    double farthest = 0.0;
    for (int step = 0; step < kSteps; ++step) {
      const PlatePatch patch = patch_of(region);
      const auto places = solve_thin_plate(mesh_, regions_.around(), patch, options_.memory);
      if (places.empty()) break;
      double move = 0.0;
      for (std::size_t k = 0; k < places.size(); ++k) {
        Eigen::Vector3d& place = mesh_.vertices[patch.free[k].vertex];
        move = std::max(move, (places[k] - place).norm());
        place = places[k];
      }
      farthest = std::max(farthest, move);
      if (move < kAtRest * options_.voxel_size) break;
    }
    return farthest;
  }

 private:
  PlatePatch patch_of(FairRegion region) const {
    const std::vector<std::uint32_t> vertices = region.with_approach();
    std::vector<std::uint8_t> known(vertices.size(), 0);
    std::fill(known.begin() + static_cast<long>(region.vertices.size()), known.end(), 1);
    bend_to(mesh_, regions_.around(),
            continued_curvature(mesh_, regions_.around(), vertices, known, options_.voxel_size),
            region);
    return {std::move(region.vertices), std::move(region.border)};
  }

  TriangleMesh& mesh_;
  const FairRegions& regions_;
  const FairFillOptions& options_;
};

}  // namespace

BentRegions bend_filled_regions(TriangleMesh mesh, const std::vector<ViewSampler>& views,
                                const FairFillOptions& options) {
  BentRegions bent{std::move(mesh), {}, 0.0};
  bent.moved.assign(bent.mesh.vertices.size(), 0);
  const TriangleMesh before = bent.mesh;
  const FairRegions regions(before, views, options);
  Bending bending(bent.mesh, regions, options);
  for (const FairRegion& region : regions.all()) {
    if (!region.curved || region.vertices.size() > options.most_bent) continue;
    const double move = bending.bend(region);
    bent.farthest = std::max(bent.farthest, move);
    for (const PlateVertex& vertex : region.vertices)
      bent.moved[vertex.vertex] = before.filled[vertex.vertex];
  }
  bent.mesh.normals = vertex_normals(bent.mesh);
  return bent;
}

}  // namespace relief::fusion
