#include "apps/reports/report.h"

#include <iostream>

#include <sys/resource.h>

#include "apps/version.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

Json to_json(const RigidMotion& motion) {
  Json rows = Json::array();
  for (int r = 0; r < 4; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 4; ++c) row.push_back(motion.matrix()(r, c));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::filesystem::path report_path(const CommonOptions& common,
                                  const std::filesystem::path& output) {
  return common.report.empty() ? output.parent_path() / "report.json" : common.report;
}

namespace {

// The report at `path`, or a new one when there is none or it is no report of ours.
Json existing_report(const std::filesystem::path& path) {
  if (const auto text = read_file(path)) {
    Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
    if (report.is_object() && report.contains("relief")) return report;
  }
  return Json::object();
}

}  // namespace

Result<void> write_report(const std::filesystem::path& path, const std::string& name,
                          const Json& section, const CommonOptions& common) {
  Json report = existing_report(path);
  report["relief"] = kVersion;
  report[name] = section;
  const std::string text = report.dump(2) + "\n";
  if (common.json) std::cout << text << std::flush;
  return write_file(path, text);
}

Result<void> report_on_request(const std::string& name, const Json& section,
                               const CommonOptions& common) {
  if (common.json) std::cout << Json({{name, section}}).dump(2) << "\n" << std::flush;
  if (common.report.empty()) return {};
  CommonOptions silent = common;
  silent.json = false;
  return write_report(common.report, name, section, silent);
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace relief
