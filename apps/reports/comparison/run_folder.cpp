#include "apps/reports/comparison/run_folder.h"

#include <utility>

#include <Eigen/Core>

#include "relief/io/mesh_io.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

Result<ReportFigures> read_report(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "report.json";
  const auto text = read_file(path);
  if (!text)
    return Error{ErrorKind::kBadInput,
                 folder.string() + ": this is no folder of `relief run`: " + text.error().message};
  Json report = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object() || !report.contains("relief"))
    return Error{ErrorKind::kBadInput,
                 path.string() + ": this is no report of relief: `relief run` writes one"};
  for (const char* section : {"run", "align", "refine", "merge"})
    if (report.contains(section)) return ReportFigures(std::move(report));
  return Error{ErrorKind::kBadInput,
               path.string() + ": this report is not of a run: name folders of `relief run`"};
}

std::string unit_in(const std::filesystem::path& project) {
  const auto text = read_file(project);
  if (!text) return "";
  const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return "";
  return json.contains("unit") && json["unit"].is_string() ? json["unit"].get<std::string>() : "mm";
}

bool any_found(const ReportFigures& report) {
  const Json* kinds = report.find("/run/cache");
  if (!kinds || !kinds->is_object()) return false;
  for (const Json& kind : *kinds)
    if (kind.is_object() && kind.contains("found") && kind["found"].is_number() &&
        kind["found"].get<double>() > 0.0)
      return true;
  return false;
}

std::vector<std::string> what_is_missing(const RunFolder& run) {
  std::vector<std::string> missing;
  const auto need = [&](bool there, const char* what) {
    if (!there) missing.emplace_back(what);
  };
  need(run.report.find("/run"), "the options and the inputs of the run");
  need(!run.report.find("/run") || run.report.size("/run/inputs") > 0, "hashes of the inputs");
  need(run.report.find("/align"), "the alignment");
  need(!run.unit.empty(), "the refined views (scan.json)");
  need(run.report.find("/merge"), "the figures of the model");
  need(run.model.has_value(), "model.ply");
  return missing;
}

std::optional<RigidMotion> pose_in(const Json& view) {
  if (!view.is_object() || !view.contains("world_from_view")) return std::nullopt;
  const Json& rows = view["world_from_view"];
  Eigen::Matrix4d matrix;
  if (!rows.is_array() || rows.size() != 4) return std::nullopt;
  for (int r = 0; r < 4; ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4) return std::nullopt;
    for (int c = 0; c < 4; ++c) {
      if (!rows[r][c].is_number()) return std::nullopt;
      matrix(r, c) = rows[r][c].get<double>();
    }
  }
  const auto pose = rigid_motion_from_matrix(matrix, "world_from_view");
  return pose ? std::optional(*pose) : std::nullopt;
}

}  // namespace

std::vector<NamedPose> RunFolder::poses() const {
  std::vector<NamedPose> poses;
  for (const std::string& entry : report.entries(report.alignment() + "/views")) {
    if (!report.truth(entry + "/aligned").value_or(false)) continue;
    if (const auto pose = pose_in(*report.find(entry)))
      poses.push_back({report.text(entry + "/name"), *pose});
  }
  return poses;
}

Result<RunFolder> read_run_folder(const std::filesystem::path& folder) {
  auto report = read_report(folder);
  if (!report) return report.error();
  RunFolder run{.folder = folder, .report = std::move(*report)};
  run.unit = unit_in(folder / "scan.json");
  if (std::filesystem::exists(folder / "model.ply")) {
    auto model = read_mesh(folder / "model.ply");
    if (!model) return model.error();
    run.model = std::move(*model);
  }
  run.missing = what_is_missing(run);
  run.finished = run.report.find("/run/cache") != nullptr;
  run.took_earlier_results = any_found(run.report);
  return run;
}

}  // namespace relief
