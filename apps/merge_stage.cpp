#include <chrono>

#include <fmt/format.h>

#include "apps/console.h"
#include "apps/mesh_report.h"
#include "apps/stages.h"

namespace relief {

Result<MergeStage> merge_stage(const ScanProject& project, const MergeOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  auto merged = merge_views(project.views, options, console_progress("merge"));
  if (!merged) return merged.error();
  for (const std::string& note : merged->notes) Console::info(note);

  MergeStage stage;
  stage.report = to_json(merged->check);
  stage.report["filled_area_fraction"] = merged->filled_area_fraction;
  stage.report["components_removed"] = merged->components_removed;
  stage.report["faces_removed"] = merged->faces_removed;
  stage.report["voxel_size"] = merged->voxel_size;
  stage.report["truncation"] = merged->truncation;
  stage.report["seconds"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
