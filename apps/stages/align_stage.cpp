#include <vector>

#include <fmt/format.h>

#include "apps/reports/console.h"
#include "apps/reports/pair_table.h"
#include "apps/stages/stages.h"
#include "relief/registration/align_views.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

Json view_report(const registration::ViewReport& view) {
  Json report = {{"name", view.name},
                 {"world_from_view", to_json(view.world_from_view)},
                 {"aligned", view.aligned},
                 {"status", to_string(view.status)},
                 {"pose_std", std::vector<double>(view.pose_std.begin(), view.pose_std.end())}};
  Json& covariance = report["pose_covariance"] = Json::array();
  for (const auto& row : view.pose_covariance.rowwise())
    covariance.push_back(std::vector<double>(row.begin(), row.end()));
  if (!view.reason.empty()) report["reason"] = view.reason;
  return report;
}

Json pair_report(const registration::PairFit& pair, const registration::Alignment& alignment) {
  Json directions = Json::array();
  for (const registration::DegenerateDirection& direction : pair.degenerate_directions)
    directions.push_back(direction.description);
  return {{"a", alignment.views[pair.a].name},
          {"b", alignment.views[pair.b].name},
          {"overlap", pair.overlap},
          {"rms", pair.rms},
          {"correspondences", pair.correspondences},
          {"grade", to_string(pair.grade)},
          {"normal_maps", pair.normal_maps},
          {"degenerate_directions", std::move(directions)}};
}

Json alignment_report(const registration::Alignment& alignment) {
  Json report = {{"termination", to_string(alignment.termination)},
                 {"iterations", alignment.iterations},
                 {"rms", alignment.rms},
                 {"views", Json::array()},
                 {"pairs", Json::array()}};
  for (const registration::ViewReport& view : alignment.views)
    report["views"].push_back(view_report(view));
  for (const registration::PairFit& pair : alignment.pairs)
    report["pairs"].push_back(pair_report(pair, alignment));
  return report;
}

// The whole table where it can be taken in at a glance, else with -v.
void log_pairs(const registration::Alignment& alignment, const std::string& unit) {
  constexpr std::size_t kShortTable = 60;
  const auto log = alignment.pairs.size() <= kShortTable ? Console::info : Console::detail;
  if (!alignment.pairs.empty())
    for (const std::string& line : pair_table(alignment, unit)) log(line);
  Console::info(count_grades(alignment));
}

}  // namespace

Result<AlignStage> align_stage(ScanProject& project, const registration::AlignOptions& options) {
  const Stopwatch watch;
  const auto alignment =
      registration::align_views(project.views, options, console_progress("align"));
  if (!alignment) return alignment.error();

  for (const std::string& note : alignment->notes) Console::info(note);
  log_pairs(*alignment, project.unit);
  std::size_t aligned = 0;
  for (const registration::ViewReport& view : alignment->views) aligned += view.aligned ? 1 : 0;
  registration::apply_alignment(*alignment, project.views);

  AlignStage stage;
  const bool solved = alignment->termination != registration::RefinementTermination::kSolverFailed;
  if (!solved)
    Console::warning(
        "the poses are not refined to the end, as their equations are not finite: look for "
        "infinite or huge confidences and coordinates");
  stage.complete = alignment->complete() && solved;
  stage.report = alignment_report(*alignment);
  const double seconds = watch.seconds();
  stage.report["seconds"] = seconds;
  Console::info(fmt::format("aligned {} of {} views by {} pairs: {:.3g} {} RMS, {}, {:.1f} s",
                            aligned, project.views.size(), alignment->pairs.size(), alignment->rms,
                            project.unit, to_string(alignment->termination), seconds));
  return stage;
}

void warn_of_unaligned(const Json& align_report) {
  for (const Json& view : align_report["views"]) {
    if (view["status"] == to_string(registration::PoseStatus::kVerified)) continue;
    Console::warning(
        "view " + view["name"].get<std::string>() +
        (view["aligned"] ? " is kept at a pose that is not verified: " : " is not aligned: ") +
        view["reason"].get<std::string>());
  }
}

}  // namespace relief
