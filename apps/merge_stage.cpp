#include <chrono>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "apps/console.h"
#include "apps/mesh_report.h"
#include "apps/stages.h"

namespace relief {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Json merge_report(const MergeResult& merged) {
  Json report = to_json(merged.check);
  report["filled_area_fraction"] = merged.filled_area_fraction;
  report["components_removed"] = merged.components_removed;
  report["faces_removed"] = merged.faces_removed;
  report["voxel_size"] = merged.voxel_size;
  report["truncation"] = merged.truncation;
  return report;
}

Json polish_report(const PolishedMesh& polished) {
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

void log_polish(const PolishedMesh& polished, const std::string& unit) {
  if (polished.status == PolishStatus::kNotConverged)
    Console::warning("polishing did not converge: its last iterate is kept");
  if (polished.rounds == 0)
    Console::info(fmt::format("not polished: {}", to_string(polished.status)));
  else
    Console::info(fmt::format("polished: vertices moved {:.3g} {} RMS, {} held back, {:.1f} s",
                              polished.rms_move, unit, polished.damped, polished.seconds));
}

// Refines the merged mesh with the views' normals; moving the vertices changes its check, and what
// was closed must still be.
Result<Json> polish(const ScanProject& project, const PolishOptions& options, MergeResult& merged) {
  PolishOptions scaled = options;
  if (!(scaled.normals.max_distance > 0.0)) scaled.normals.max_distance = merged.truncation;
  auto polished = polish_mesh(merged.mesh, project.views, scaled, console_progress("polish"));
  if (!polished) return polished.error();
  log_polish(*polished, project.unit);
  if (polished->rounds > 0) {
    const bool was_closed = merged.check.watertight();
    merged.mesh = std::move(polished->mesh);
    merged.check = check_mesh(merged.mesh);
    if (was_closed && !merged.check.watertight())
      return Error{ErrorKind::kUnsolvable,
                   "polishing left the surface no closed manifold; merge with --no-polish"};
  }
  return polish_report(*polished);
}

// Fewer faces, when the options ask for it.
Result<void> decimate(const DecimationOptions& options, MergeResult& merged) {
  if (options.faces == 0 && !(options.max_error > 0.0)) return {};
  auto decimated = decimate_mesh(merged.mesh, options);
  if (!decimated) return decimated.error();
  Console::info(fmt::format("decimated: {} of {} faces", decimated->mesh.faces.size(),
                            merged.mesh.faces.size()));
  merged.mesh = std::move(decimated->mesh);
  merged.check = decimated->check;
  return {};
}

}  // namespace

Result<MergeStage> merge_stage(const ScanProject& project, const MergeStageOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  MergeOptions merge_options = options.merge;
  merge_options.threads = options.threads;
  auto merged = merge_views(project.views, merge_options, console_progress("merge"));
  if (!merged) return merged.error();
  for (const std::string& note : merged->notes) Console::info(note);

  Json polish_section;
  if (options.polish) {
    PolishOptions polish_options = *options.polish;
    polish_options.threads = options.threads;
    auto section = polish(project, polish_options, *merged);
    if (!section) return section.error();
    polish_section = std::move(*section);
  }

  if (const auto done = decimate(options.decimation, *merged); !done) return done.error();

  MergeStage stage;
  stage.report = merge_report(*merged);
  if (options.polish) stage.report["polish"] = polish_section;
  stage.report["seconds"] = seconds_since(start);
  stage.report["peak_memory_mb"] = peak_memory_mb();
  Console::info(
      fmt::format("merged: {} vertices, {} faces, {}, {:.1f} % of the area filled, {:.1f} s",
                  merged->check.vertices, merged->check.faces,
                  merged->check.watertight() ? "watertight" : "not watertight (holes kept)",
                  100.0 * merged->filled_area_fraction, stage.report["seconds"].get<double>()));
  stage.mesh = std::move(merged->mesh);
  return stage;
}

}  // namespace relief
