#pragma once

#include <optional>
#include <string>

#include "apps/reports/comparison/run_comparison.h"
#include "apps/reports/report.h"

namespace relief {

/// The section `comparison` of a report.
Json to_json(const RunComparison& comparison);

/// A figure's value as in the report: a whole number, a truth, or a number; null for nothing.
Json json_of(Quantity quantity, const std::optional<double>& value);

/// The unit of a quantity, for readers; empty for those without one. `length` is that of lengths.
std::string unit_of(Quantity quantity, const std::string& length);

/// Of a figure that is not there.
inline constexpr char kNoFigure[] = "–";

/// The same figures for people, on standard output.
void print_tables(const RunComparison& comparison);

}  // namespace relief
