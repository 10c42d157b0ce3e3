#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/reports/html/report_content.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

struct HtmlReportOptions {
  /// Faces of the model in the page, at most; 0: the page has no model to look at.
  std::size_t viewer_faces = 200000;
};

/// Gathers what the page shows. `report` is a report.json, `project` the scan.json beside it (null
/// if there is none), `mesh` the model (null if there is none).
ReportContent report_content(Json report, const Json& project, const TriangleMesh* mesh,
                             const HtmlReportOptions& options);

/// The whole page, which needs no other file and no network.
std::string html_page(const ReportContent& content);

/// The files of a page.
struct HtmlReportFiles {
  std::filesystem::path page;
  std::filesystem::path report;  ///< A report.json.
  std::filesystem::path folder;  ///< Names the page; its scan.json, if there is one, is read.
};

/// Writes the page from the report, the project and `mesh`, the model (null: there is none), and
/// logs it. Errors: kBadInput when the report cannot be read, kCannotWrite.
Result<void> write_html_report(const HtmlReportFiles& files, const TriangleMesh* mesh,
                               const HtmlReportOptions& options);

/// Adds --viewer-faces.
void add_html_report_options(CLI::App& command, HtmlReportOptions& options);

}  // namespace relief
