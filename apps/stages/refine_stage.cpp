#include <numbers>

#include <fmt/format.h>

#include "apps/reports/console.h"
#include "apps/stages/stages.h"
#include "relief/hybrid/refine_views.h"
#include "scan/base/median_deviation.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

bool is_failure(hybrid::RefineStatus status) {
  return status == hybrid::RefineStatus::kNotConverged ||
         status == hybrid::RefineStatus::kSolverFailed;
}

Json view_report(const hybrid::RefinedView& refined) {
  return {{"name", refined.view.name},
          {"status", to_string(refined.status)},
          {"sigma_position", refined.sigma_position},
          {"sigma_normal_deg", refined.sigma_normal * kDegrees},
          {"lambda", refined.lambda},
          {"normal_bias_deg", refined.bias_rms * kDegrees},
          {"iterations", refined.iterations},
          {"rounds", refined.rounds},
          {"seconds", refined.seconds},
          {"rms_change", refined.rms_change},
          {"median_deviation", median_deviation(refined.view)},
          {"samples_refined", refined.refined},
          {"samples_kept", refined.kept},
          {"flying_samples", refined.flying},
          {"filled_samples", refined.filled}};
}

void log_view(const hybrid::RefinedView& refined, const std::string& unit) {
  if (refined.status == hybrid::RefineStatus::kContradiction) {
    Console::warning(fmt::format("view {}: {}; it stays as measured: check the axes of its normals",
                                 refined.view.name, to_string(refined.status)));
  } else if (is_failure(refined.status)) {
    Console::warning(fmt::format("view {}: {}", refined.view.name, to_string(refined.status)));
  } else if (refined.status != hybrid::RefineStatus::kRefined) {
    Console::info(fmt::format("view {}: {}", refined.view.name, to_string(refined.status)));
  } else {
    Console::detail(fmt::format(
        "view {}: noise {:.3g} {} and {:.2f} deg, bias {:.2f} deg, moved {:.3g} {} RMS, {} steps",
        refined.view.name, refined.sigma_position, unit, refined.sigma_normal * kDegrees,
        refined.bias_rms * kDegrees, refined.rms_change, unit, refined.iterations));
  }
}

}  // namespace

Result<RefineStage> refine_stage(ScanProject& project, const hybrid::RefineOptions& options,
                                 std::size_t memory) {
  const Stopwatch watch;
  auto refined = hybrid::refine_views(project.views, options, console_progress("refine"), memory);
  if (!refined) return refined.error();

  RefineStage stage;
  stage.report["views"] = Json::array();
  std::size_t improved = 0;
  for (std::size_t i = 0; i < refined->size(); ++i) {
    hybrid::RefinedView& view = (*refined)[i];
    log_view(view, project.unit);
    stage.report["views"].push_back(view_report(view));
    stage.complete = stage.complete && !is_failure(view.status);
    improved += view.status == hybrid::RefineStatus::kRefined ? 1 : 0;
    project.views[i] = std::move(view.view);
  }
  stage.any_refined = improved > 0;
  stage.report["seconds"] = watch.seconds();
  Console::info(fmt::format("refined {} of {} views in {:.1f} s", improved, refined->size(),
                            stage.report["seconds"].get<double>()));
  return stage;
}

}  // namespace relief
