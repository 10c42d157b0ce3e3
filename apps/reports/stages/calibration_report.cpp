#include "apps/reports/stages/calibration_report.h"

#include <cstddef>

#include <fmt/format.h>

#include "apps/console/console.h"

namespace relief {

Json calibration_report(const registration::SensorCalibration& calibration,
                        const std::vector<RangeView>& views) {
  Json errors = Json::array(), list = Json::array();
  for (const registration::CalibratedError& error : calibration.errors)
    errors.push_back({{"error", to_string(error.error)},
                      {"per_view", error.per_view},
                      {"held_out_gain", error.held_out_gain},
                      {"held_out_gain_std", error.held_out_gain_std},
                      {"left_out_views_gain", error.left_out_views_gain},
                      {"left_out_views_gain_std", error.left_out_views_gain_std},
                      {"size", error.size},
                      {"size_std", error.size_std}});
  for (std::size_t i = 0; i < views.size() && calibration.found(); ++i)
    list.push_back({{"name", views[i].name},
                    {"sensor", calibration.views[i].sensor},
                    {"coefficients", calibration.views[i].coefficients},
                    {"coefficient_std", calibration.views[i].coefficient_std}});
  return {{"errors", errors},
          {"views", list},
          {"deviation_before", calibration.deviation_before},
          {"deviation_after", calibration.deviation_after},
          {"iterations", calibration.iterations},
          {"notes", calibration.notes}};
}

void log_calibration(const registration::SensorCalibration& calibration, const std::string& unit,
                     double seconds) {
  if (!calibration.found()) {
    Console::info(fmt::format("calibrated sensors in {:.1f} s: nothing to correct", seconds));
    for (const std::string& note : calibration.notes) Console::info("  " + note);
    return;
  }
  Console::info(
      fmt::format("calibrated sensors in {:.1f} s: distances of views {:.3g} -> {:.3g} {}", seconds,
                  calibration.deviation_before, calibration.deviation_after, unit));
  for (const std::string& note : calibration.notes) Console::info("  " + note);
}

}  // namespace relief
