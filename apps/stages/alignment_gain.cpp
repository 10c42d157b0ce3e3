#include "apps/stages/alignment_gain.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "scan/base/median.h"

namespace relief {

namespace {

RigidMotion motion_of(const Json& rows) {
  RigidMotion motion = RigidMotion::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) motion.matrix()(r, c) = rows[r][c].get<double>();
  return motion;
}

std::map<std::string, RigidMotion> aligned_poses(const Json& section) {
  std::map<std::string, RigidMotion> poses;
  for (const Json& view : section["views"])
    if (view["aligned"]) poses[view["name"]] = motion_of(view["world_from_view"]);
  return poses;
}

// Held views have none: they are what the others are known against.
double median_pose_std(const Json& section) {
  std::vector<double> deviations;
  for (const Json& view : section["views"]) {
    const auto std = view["pose_std"].get<std::vector<double>>();
    const double deviation = std::hypot(std[3], std[4], std[5]);
    if (view["aligned"] && deviation > 0.0) deviations.push_back(deviation);
  }
  return deviations.empty() ? 0.0 : median(deviations);
}

double mean_motion(const std::vector<RangeView>& views,
                   const std::map<std::string, RigidMotion>& before,
                   const std::map<std::string, RigidMotion>& after) {
  constexpr int kStride = 4;
  double sum = 0.0, count = 0.0;
  for (const RangeView& view : views) {
    const auto a = before.find(view.name), b = after.find(view.name);
    if (a == before.end() || b == after.end()) continue;
    for (int v = 0; v < view.height(); v += kStride) {
      for (int u = 0; u < view.width(); u += kStride) {
        if (!view.has_sample(u, v)) continue;
        const Eigen::Vector3d point = view.point(u, v);
        sum += (a->second * point - b->second * point).norm();
        count += 1.0;
      }
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

std::size_t left_out(const Json& section) {
  const auto& views = section["views"];
  return static_cast<std::size_t>(
      std::count_if(views.begin(), views.end(), [](const Json& v) { return !v["aligned"]; }));
}

}  // namespace

Json alignment_gain(const Json& first, const Json& again, const std::vector<RangeView>& views) {
  const double std_first = median_pose_std(first), std_again = median_pose_std(again);
  const std::size_t lost = left_out(again);
  const bool solved = again.value("termination", "") != "solver failed";
  return {{"rms", {{"first", first["rms"]}, {"again", again["rms"]}}},
          {"pose_std", {{"first", std_first}, {"again", std_again}}},
          {"moved", mean_motion(views, aligned_poses(first), aligned_poses(again))},
          {"left_out", lost},
          {"kept", solved && std_again <= std_first && lost == 0}};
}

std::vector<std::string> gain_table(const Json& gain, const std::string& unit) {
  const auto row = [&](const char* name, const char* key) {
    return fmt::format("  {:<22}{:>12.3g}{:>12.3g}", name, gain["rms"][key].get<double>(),
                       gain["pose_std"][key].get<double>());
  };
  std::string verdict;
  if (const auto lost = gain["left_out"].get<std::size_t>(); lost > 0)
    verdict = fmt::format(": {} of the views no longer fit, the first poses are kept", lost);
  else if (!gain["kept"])
    verdict = ": no gain expected, the first poses are kept";
  return {
      fmt::format("  {:<22}{:>12}{:>12}  [{}]", "alignment of", "rms", "pose std", unit),
      row("views as measured", "first"), row("refined views", "again"),
      fmt::format("  moved by {:.3g} {} on average{}", gain["moved"].get<double>(), unit, verdict)};
}

}  // namespace relief
