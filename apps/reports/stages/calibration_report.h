#pragma once

#include <string>
#include <vector>

#include "apps/reports/report.h"
#include "relief/registration/calibrate_views.h"
#include "relief/scan/range_view.h"

namespace relief {

/// The section `calibrate` of a report.
Json calibration_report(const registration::SensorCalibration& calibration,
                        const std::vector<RangeView>& views);

void log_calibration(const registration::SensorCalibration& calibration, const std::string& unit,
                     double seconds);

}  // namespace relief
