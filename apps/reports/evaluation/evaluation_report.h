#pragma once

#include <string>

#include "apps/reports/report.h"
#include "relief/evaluation/error_statistics.h"
#include "relief/evaluation/mesh_errors.h"
#include "relief/evaluation/pose_errors.h"
#include "relief/evaluation/view_errors.h"
#include "relief/scan/mesh_check.h"

namespace relief {

Json to_json(const evaluation::MeshComparison& comparison, const MeshCheck& check);
Json to_json(const evaluation::DistanceReport& report);
Json to_json(const evaluation::ViewErrorReport& report);
Json to_json(const evaluation::ViewSpectra& spectra);
Json to_json(const evaluation::PoseErrorReport& report);

/// The same figures for people, on standard output. `unit` is that of the lengths.
void print_table(const evaluation::MeshComparison& comparison, const MeshCheck& check,
                 const std::string& unit);
void print_table(const evaluation::MutualDistances& distances, const std::string& unit);
void print_table(const evaluation::ViewErrorReport& report, const std::string& unit);
void print_table(const evaluation::ViewSpectra& spectra, const std::string& unit);
void print_table(const evaluation::PoseErrorReport& report, const std::string& unit);

}  // namespace relief
