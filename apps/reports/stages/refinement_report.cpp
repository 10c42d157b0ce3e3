#include "apps/reports/stages/refinement_report.h"

#include <algorithm>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "apps/console/console.h"
#include "scan/base/median_deviation.h"

namespace relief {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

Json spectrum_report(const std::vector<hybrid::DeviationBand>& spectrum) {
  Json bands = Json::array();
  for (const hybrid::DeviationBand& band : spectrum)
    bands.push_back(
        {{"wavelength", band.wavelength}, {"measured", band.measured}, {"refined", band.refined}});
  return bands;
}

Json view_report(const hybrid::RefineSummary& refined, const RangeView& view) {
  return {{"name", view.name},
          {"status", to_string(refined.status)},
          {"sigma_position", refined.sigma_position},
          {"sigma_normal_deg", refined.sigma_normal * kDegrees},
          {"lambda", refined.lambda},
          {"normal_bias_deg", refined.bias_rms * kDegrees},
          {"iterations", refined.iterations},
          {"rounds", refined.rounds},
          {"seconds", refined.seconds},
          {"rms_change", refined.rms_change},
          {"median_deviation", median_deviation(view)},
          {"samples_refined", refined.refined},
          {"samples_kept", refined.kept},
          {"flying_samples", refined.flying},
          {"filled_samples", refined.filled},
          {"spectrum", spectrum_report(refined.spectrum)}};
}

void log_view(const hybrid::RefineSummary& refined, const std::string& name,
              const std::string& unit) {
  if (refined.status == hybrid::RefineStatus::kContradiction) {
    Console::warning(fmt::format("view {}: {}; it stays as measured: check the axes of its normals",
                                 name, to_string(refined.status)));
  } else if (refined.failed()) {
    Console::warning(fmt::format("view {}: {}", name, to_string(refined.status)));
  } else if (refined.status == hybrid::RefineStatus::kNoNormals) {
    Console::detail(fmt::format("view {}: {}", name, to_string(refined.status)));
  } else if (refined.status != hybrid::RefineStatus::kRefined) {
    Console::info(fmt::format("view {}: {}", name, to_string(refined.status)));
  } else {
    Console::detail(fmt::format(
        "view {}: noise {:.3g} {} and {:.2f} deg, bias {:.2f} deg, moved {:.3g} {} RMS, {} steps",
        name, refined.sigma_position, unit, refined.sigma_normal * kDegrees,
        refined.bias_rms * kDegrees, refined.rms_change, unit, refined.iterations));
  }
}

}  // namespace

Json refinement_report(const std::vector<hybrid::RefineSummary>& refinements,
                       const std::vector<RangeView>& views) {
  Json report;
  report["views"] = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i)
    report["views"].push_back(view_report(refinements[i], views[i]));
  return report;
}

void log_refinement(const std::vector<hybrid::RefineSummary>& refinements,
                    const std::vector<RangeView>& views, const std::string& unit, double seconds) {
  for (std::size_t i = 0; i < views.size(); ++i) log_view(refinements[i], views[i].name, unit);
  const auto count = [&](hybrid::RefineStatus status) {
    return std::count_if(refinements.begin(), refinements.end(),
                         [&](const auto& refinement) { return refinement.status == status; });
  };
  const auto without_normals = count(hybrid::RefineStatus::kNoNormals);
  Console::info(fmt::format(
      "refined {} of {} views in {:.1f} s{}", count(hybrid::RefineStatus::kRefined), views.size(),
      seconds, without_normals > 0 ? fmt::format(", {} have no normals", without_normals) : ""));
}

}  // namespace relief
