#include "apps/reports/stages/alignment_report.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "apps/console/console.h"
#include "scan/base/name_list.h"

namespace relief {

namespace {

std::vector<std::string> pair_table(const registration::Alignment& alignment,
                                    const std::string& unit) {
  std::size_t width = 4;
  for (const registration::PairFit& pair : alignment.pairs)
    width = std::max(width,
                     alignment.views[pair.a].name.size() + 3 + alignment.views[pair.b].name.size());
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("{:<{}}  overlap  {:>10}  samples  grade", "pair", width, "rms [" + unit + "]"));
  for (const registration::PairFit& pair : alignment.pairs) {
    const std::string names = alignment.views[pair.a].name + " - " + alignment.views[pair.b].name;
    lines.push_back(fmt::format("{:<{}}  {:>5.0f} %  {:>10.3g}  {:>7}  {}{}", names, width,
                                100.0 * pair.overlap, pair.rms, pair.correspondences,
                                to_string(pair.status), pair.normal_maps ? ", normal maps" : ""));
    for (const registration::DegenerateDirection& direction : pair.degenerate_directions)
      lines.push_back("    degenerate direction: " + direction.description);
  }
  return lines;
}

std::string count_grades(const registration::Alignment& alignment) {
  std::string text = fmt::format("{} pairs", alignment.pairs.size());
  const char* separator = ": ";
  for (const registration::PairStatus grade :
       {registration::PairStatus::kDetermined, registration::PairStatus::kDegenerate,
        registration::PairStatus::kThin, registration::PairStatus::kMisfit}) {
    const auto count =
        std::count_if(alignment.pairs.begin(), alignment.pairs.end(),
                      [&](const registration::PairFit& pair) { return pair.status == grade; });
    if (count == 0) continue;
    text += fmt::format("{}{} {}", separator, count, to_string(grade));
    separator = ", ";
  }
  return text;
}

Json in_words(const std::vector<registration::DegenerateDirection>& directions) {
  Json words = Json::array();
  for (const registration::DegenerateDirection& direction : directions)
    words.push_back(direction.description);
  return words;
}

// Views that are not verified for the same reason.
struct UnverifiedViews {
  bool aligned = false;
  std::string reason;
  std::vector<std::string> names;
};

// In the order of their first views.
std::vector<UnverifiedViews> unverified_views(const registration::Alignment& alignment) {
  std::vector<UnverifiedViews> all;
  for (const registration::ViewReport& view : alignment.views) {
    if (view.status == registration::PoseStatus::kVerified) continue;
    auto alike = std::ranges::find_if(all, [&](const UnverifiedViews& views) {
      return views.aligned == view.aligned && views.reason == view.reason;
    });
    if (alike == all.end()) alike = all.insert(all.end(), {view.aligned, view.reason, {}});
    alike->names.push_back(view.name);
  }
  return all;
}

std::vector<double> roots_of(const Vector6d& variances) {
  const Vector6d roots = variances.cwiseMax(0.0).cwiseSqrt();
  return {roots.begin(), roots.end()};
}

Json view_report(const registration::ViewReport& view) {
  Json report = {{"name", view.name},
                 {"world_from_view", to_json(view.world_from_view)},
                 {"aligned", view.aligned},
                 {"status", to_string(view.status)},
                 {"pose_std", std::vector<double>(view.pose_std.begin(), view.pose_std.end())}};
  Json& covariance = report["pose_covariance"] = Json::array();
  for (const auto& row : view.pose_covariance.rowwise())
    covariance.push_back(std::vector<double>(row.begin(), row.end()));
  if (const auto variances = view.sensor_covariance.diagonal(); variances.maxCoeff() > 0.0)
    report["sensor_std"] = roots_of(variances);
  if (!view.reason.empty()) report["reason"] = view.reason;
  if (!view.kept_motions.empty()) report["kept_motions"] = in_words(view.kept_motions);
  return report;
}

Json pair_report(const registration::PairFit& pair, const registration::Alignment& alignment) {
  return {{"a", alignment.views[pair.a].name},
          {"b", alignment.views[pair.b].name},
          {"overlap", pair.overlap},
          {"rms", pair.rms},
          {"correspondences", pair.correspondences},
          {"grade", to_string(pair.status)},
          {"normal_maps", pair.normal_maps},
          {"degenerate_directions", in_words(pair.degenerate_directions)}};
}

Json loop_report(const registration::LoopClosure& loop, const registration::Alignment& alignment) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  Json views = Json::array();
  for (const std::size_t view : loop.views) views.push_back(alignment.views[view].name);
  return {{"views", std::move(views)},
          {"radius", loop.radius},
          {"length", loop.length},
          {"length_std", loop.length_std},
          {"angle_deg", loop.angle * kDegrees},
          {"angle_std_deg", loop.angle_std * kDegrees},
          {"ratio", loop.ratio()}};
}

Json solve_report(const registration::SolverSummary& solve) {
  return {{"stage", to_string(solve.stage)}, {"termination", to_string(solve.termination)},
          {"iterations", solve.iterations},  {"initial_cost", solve.initial_cost},
          {"final_cost", solve.final_cost},  {"message", solve.message},
          {"seconds", solve.seconds}};
}

std::string count_solves(const registration::Alignment& alignment) {
  int iterations = 0;
  double seconds = 0.0;
  for (const registration::SolverSummary& solve : alignment.solves) {
    iterations += solve.iterations;
    seconds += solve.seconds;
  }
  return fmt::format("{} solves for all poses in {} iterations, {:.2f} s", alignment.solves.size(),
                     iterations, seconds);
}

std::string verdict_on(const reconstruction::AlignmentGain& gain) {
  switch (gain.verdict) {
    case reconstruction::GainVerdict::kGain:
      return "";
    case reconstruction::GainVerdict::kViewsLost:
      return fmt::format(": {} of the views no longer fit, the first poses are kept",
                         gain.left_out);
    case reconstruction::GainVerdict::kNoGain:
    case reconstruction::GainVerdict::kSolverFailed:
      return ": no gain expected, the first poses are kept";
  }
  return "";
}

// All that the user should know, one line each.
std::vector<std::string> notes_on(const registration::Alignment& alignment) {
  std::vector<std::string> notes = alignment.notes;
  if (!alignment.sensor_error.empty()) notes.push_back(alignment.sensor_error);
  return notes;
}

// How the refinement ended; empty where there is nothing to know, as the views stand still but for
// less than their poses err by.
std::string words_on_end(const registration::Alignment& alignment) {
  if (alignment.termination != registration::RefinementTermination::kIterationLimit)
    return fmt::format(", {}", to_string(alignment.termination));
  if (alignment.stands_still() || alignment.spacing == 0.0) return "";
  return fmt::format(", the last step still moved views by up to {:.2g} sample spacings",
                     alignment.last_motion / alignment.spacing);
}

}  // namespace

Json to_json(const registration::Alignment& alignment) {
  Json report = {{"termination", to_string(alignment.termination)},
                 {"iterations", alignment.iterations},
                 {"last_motion", alignment.last_motion},
                 {"spacing", alignment.spacing},
                 {"stands_still", alignment.stands_still()},
                 {"rms", alignment.rms},
                 {"views", Json::array()},
                 {"pairs", Json::array()},
                 {"loops", Json::array()},
                 {"solves", Json::array()},
                 {"notes", notes_on(alignment)}};
  for (const registration::ViewReport& view : alignment.views)
    report["views"].push_back(view_report(view));
  for (const registration::PairFit& pair : alignment.pairs)
    report["pairs"].push_back(pair_report(pair, alignment));
  for (const registration::LoopClosure& loop : alignment.loops)
    report["loops"].push_back(loop_report(loop, alignment));
  for (const registration::SolverSummary& solve : alignment.solves)
    report["solves"].push_back(solve_report(solve));
  return report;
}

Json to_json(const reconstruction::AlignmentGain& gain) {
  return {{"rms", {{"first", gain.first_rms}, {"again", gain.second_rms}}},
          {"pose_std", {{"first", gain.first_pose_std}, {"again", gain.second_pose_std}}},
          {"moved", gain.mean_motion},
          {"left_out", gain.left_out},
          {"kept", gain.kept()}};
}

void log_alignment(const registration::Alignment& alignment, const std::string& unit,
                   double seconds) {
  constexpr std::size_t kShortTable = 60;
  for (const std::string& note : notes_on(alignment)) Console::info(note);
  const auto log = alignment.pairs.size() <= kShortTable ? Console::info : Console::detail;
  if (!alignment.pairs.empty())
    for (const std::string& line : pair_table(alignment, unit)) log(line);
  Console::info(count_grades(alignment));
  if (!alignment.solves.empty()) Console::detail(count_solves(alignment));
  if (!alignment.solved())
    Console::warning(
        "the poses are not refined to the end, as their equations are not finite: look for "
        "infinite or huge confidences and coordinates");
  const auto aligned = std::count_if(alignment.views.begin(), alignment.views.end(),
                                     [](const auto& view) { return view.aligned; });
  Console::info(fmt::format("aligned {} of {} views by {} pairs: {:.3g} {} RMS{}, {:.1f} s",
                            aligned, alignment.views.size(), alignment.pairs.size(), alignment.rms,
                            unit, words_on_end(alignment), seconds));
}

void warn_of_unverified(const registration::Alignment& alignment) {
  for (const UnverifiedViews& views : unverified_views(alignment)) {
    const bool one = views.names.size() == 1;
    const char* kept = one ? " is kept at a pose that is not verified: "
                           : " are kept at poses that are not verified: of each, ";
    const char* left = one ? " is not aligned: " : " are not aligned: of each, ";
    Console::warning((one ? "view " : "views ") + name_list(views.names) +
                     (views.aligned ? kept : left) + views.reason);
  }
}

void log_gain(const reconstruction::AlignmentGain& gain, const std::string& unit) {
  const auto row = [](const char* name, double rms, double pose_std) {
    return fmt::format("  {:<22}{:>12.3g}{:>12.3g}", name, rms, pose_std);
  };
  Console::info(fmt::format("  {:<22}{:>12}{:>12}  [{}]", "alignment of", "rms", "pose std", unit));
  Console::info(row("views as measured", gain.first_rms, gain.first_pose_std));
  Console::info(row("refined views", gain.second_rms, gain.second_pose_std));
  Console::info(
      fmt::format("  moved by {:.3g} {} on average{}", gain.mean_motion, unit, verdict_on(gain)));
}

}  // namespace relief
