#pragma once

#include <string>

#include "apps/reports/html/report_content.h"

namespace relief {

/// How far the ranges of a view deviate from what its normals say, by wavelength, before and after
/// refining: a sentence and a plot. `entry`: the view's place in the section `refine`. Empty where
/// it has no spectrum.
std::string spectrum_of_view(const ReportContent& content, const std::string& entry);

}  // namespace relief
