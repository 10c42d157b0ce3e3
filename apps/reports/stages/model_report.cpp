#include "apps/reports/stages/model_report.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "apps/console/console.h"

namespace relief {

namespace {

// A report is for reading: a mesh that is broken all over does not need all its faces listed.
constexpr std::size_t kListedFaces = 100;

Json polish_report(const hybrid::PolishSummary& polished) {
  return {{"status", to_string(polished.status)},
          {"vertices_with_normal", polished.with_normal},
          {"sigma_view_deg", polished.sigma_view * 180.0 / std::numbers::pi},
          {"rms_move", polished.rms_move},
          {"max_move", polished.max_move},
          {"vertices_damped", polished.damped},
          {"vertices_unmoved", polished.unmoved},
          {"rounds", polished.rounds},
          {"iterations", polished.iterations},
          {"seconds", polished.seconds}};
}

void log_polish(const hybrid::PolishSummary& polished, const std::string& unit) {
  if (polished.status == hybrid::PolishStatus::kNotConverged)
    Console::warning("polishing did not converge: its last iterate is kept");
  if (polished.rounds == 0)
    Console::info(fmt::format("not polished: {}", to_string(polished.status)));
  else
    Console::info(fmt::format("polished: vertices moved {:.3g} {} RMS, {} held back, {:.1f} s",
                              polished.rms_move, unit, polished.damped, polished.seconds));
}

}  // namespace

Json to_json(const MeshCheck& check) {
  Json json = {{"vertices", check.vertices},
               {"faces", check.faces},
               {"watertight", check.watertight()},
               {"manifold_edges", check.non_manifold_edges == 0},
               {"manifold_vertices", check.non_manifold_vertices == 0},
               {"oriented", check.inconsistent_edges == 0},
               {"boundary_edges", check.boundary_edges},
               {"components", check.components},
               {"genus", check.genus},
               {"volume", check.volume},
               {"non_manifold_edges", check.non_manifold_edges},
               {"non_manifold_vertices", check.non_manifold_vertices},
               {"inconsistent_edges", check.inconsistent_edges},
               {"degenerate_faces", check.degenerate_faces},
               {"duplicate_vertices", check.duplicate_vertices},
               {"unused_vertices", check.unused_vertices}};
  if (check.self_intersections) {
    const auto faces = check.self_intersections->faces();
    json["self_intersections"] = check.self_intersections->pairs.size();
    json["self_intersections_complete"] = check.self_intersections->complete;
    json["self_intersecting_faces"] = std::vector(
        faces.begin(), faces.begin() + static_cast<long>(std::min(faces.size(), kListedFaces)));
  }
  return json;
}

Json to_json(const reconstruction::Model& model) {
  const fusion::MergeSummary& merged = model.merged;
  Json report = to_json(model.check);
  report["filled_area_fraction"] = merged.filled_area_fraction;
  report["flying_samples"] = merged.flying_samples;
  report["filled_samples"] = merged.filled_samples;
  report["noisy_samples"] = merged.noisy_samples;
  report["contradicted_views"] = merged.contradicted_views;
  report["small_handles"] = merged.small_handles;
  report["handles_removed"] = merged.handles_removed;
  report["components_removed"] = merged.components_removed;
  report["faces_removed"] = merged.faces_removed;
  report["voxel_size"] = merged.voxel_size;
  report["truncation"] = merged.truncation;
  report["inter_view_stddev"] = merged.inter_view_stddev;
  report["range_exponent"] = merged.range_exponent;
  report["notes"] = merged.notes;
  if (model.polished) report["polish"] = polish_report(*model.polished);
  return report;
}

void log_model(const reconstruction::Model& model, const std::string& unit, double seconds) {
  for (const std::string& note : model.merged.notes) Console::info(note);
  if (model.polished) log_polish(*model.polished, unit);
  if (model.faces_before_decimation)
    Console::info(fmt::format("decimated: {} of {} faces", model.mesh.faces.size(),
                              *model.faces_before_decimation));
  Console::info(
      fmt::format("merged: {} vertices, {} faces, {}, {:.1f} % of the area filled, {:.1f} s",
                  model.check.vertices, model.check.faces,
                  model.check.watertight() ? "watertight" : "not watertight (holes kept)",
                  100.0 * model.merged.filled_area_fraction, seconds));
}

}  // namespace relief
