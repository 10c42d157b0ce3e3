#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/reports/html/report_figures.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// What `relief run` left in a folder. A run that did not finish leaves less.
struct RunFolder {
  std::filesystem::path folder;
  ReportFigures report;
  std::string unit;                   ///< Of the lengths; empty if there is no scan.json.
  std::optional<TriangleMesh> model;  ///< `model.ply`.
  std::vector<std::string> missing;   ///< What is not there, in words.
  bool finished = false;              ///< Whether the last run of the folder came to its end.
  bool took_earlier_results = false;  ///< Whether it did not compute everything itself.

  /// The poses of the views in the model, in the order of the report.
  std::vector<NamedPose> poses() const;
};

/// Reads a folder of `relief run`. kBadInput: it has no report.json, or one that is not of a run,
/// or a model.ply that cannot be read.
Result<RunFolder> read_run_folder(const std::filesystem::path& folder);

}  // namespace relief
