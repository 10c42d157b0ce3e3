#include "fusion/holes/fair_holes.h"

#include <utility>

#include <Eigen/Core>

#include "fusion/holes/fair_fill.h"

namespace relief::fusion {

namespace {

std::vector<std::string> notes_on(const FairFill& fair) {
  std::vector<std::string> notes;
  if (fair.unsolved > 0)
    notes.push_back(std::to_string(fair.unsolved) +
                    (fair.unsolved == 1 ? " filled region stays" : " filled regions stay") +
                    " as membranes: no plate that continues the slope of the surface around was "
                    "found for them");
  if (fair.too_large > 0)
    notes.push_back(
        std::to_string(fair.too_large) +
        (fair.too_large == 1 ? " filled region is" : " filled regions are") +
        " too large to be faired and closed by the shortest surface; if they are no part of the "
        "object, leave them open (--holes keep, --largest-fill)");
  return notes;
}

// Once more, by angles, areas, normals and samples near the plates: the membranes rose in cones to
// what was measured inside of holes.
Result<void> fair_again(FairFillOptions options, const std::vector<ViewSampler>& views,
                        TriangleMesh& mesh, const Progress& progress) {
  mesh.normals = vertex_normals(mesh);
  options.near_samples_only = true;
  auto again = fair_filled_regions(mesh, views, options, progress);
  if (!again) return again.error();
  if (!again->places.empty()) mesh.vertices.swap(again->places);
  return {};
}

}  // namespace

Result<std::vector<std::string>> fair_holes(const FairFillOptions& options,
                                            const std::vector<ViewSampler>& views,
                                            TriangleMesh& mesh, MeshCheck& check,
                                            const Progress& progress) {
  auto found = fair_filled_regions(mesh, views, options, progress);
  if (!found) return found.error();
  FairFill fair = std::move(found).value();
  std::vector<std::string> notes = notes_on(fair);
  if (fair.places.empty()) return notes;
  mesh.vertices.swap(fair.places);
  if (fair.near_samples)
    if (const auto faired = fair_again(options, views, mesh, progress); !faired)
      return faired.error();
  MeshCheck faired = check_moved_vertices(mesh, check);
  if (faired.watertight()) {
    check = std::move(faired);
  } else {
    mesh.vertices.swap(fair.places);
    notes.push_back("filled regions are left as membranes: faired they were no closed manifold");
  }
  mesh.normals = vertex_normals(mesh);
  return notes;
}

}  // namespace relief::fusion
