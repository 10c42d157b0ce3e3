#include <iostream>
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "apps/command.h"
#include "apps/console.h"
#include "apps/exit_status.h"
#include "apps/report.h"
#include "hybrid/noise.h"
#include "scan/discontinuities.h"

namespace relief {

namespace {

struct InfoCommand {
  CommonOptions common;
  ProjectInput input;
};

std::string_view to_string(PoseKind pose) {
  switch (pose) {
    case PoseKind::kAbsent:
      return "absent";
    case PoseKind::kGuess:
      return "guess";
    case PoseKind::kKnown:
      return "known";
  }
  return "unknown";
}

std::size_t normal_count(const RangeView& view) {
  std::size_t count = 0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) count += view.has_normal(u, v) ? 1 : 0;
  return count;
}

Json view_info(const RangeView& view) {
  Json info = {{"name", view.name},
               {"width", view.width()},
               {"height", view.height()},
               {"camera", to_string(view.camera.model())},
               {"projects", view.camera.can_project()},
               {"samples", view.sample_count()},
               {"normals", normal_count(view)},
               {"confidence", !view.confidence.empty()},
               {"colour", !view.colours.empty()},
               {"deviation", !view.deviation.empty()},
               {"pose", to_string(view.pose)},
               {"spacing", sample_spacing(view)}};
  if (!view.has_normals()) return info;
  const NoiseEstimate noise = estimate_noise(view, connect_samples(view));
  if (noise.usable()) {
    info["sigma_position"] = noise.sigma_position;
    info["sigma_normal_deg"] = noise.sigma_normal * 180.0 / std::numbers::pi;
    info["normal_bias_deg"] = noise.bias * 180.0 / std::numbers::pi;
  }
  return info;
}

std::string figure(const Json& view, const char* key, const char* format) {
  return view.contains(key) ? fmt::format(fmt::runtime(format), view[key].get<double>()) : "-";
}

void print_table(const Json& report) {
  fmt::print("{:<16} {:>11} {:<12} {:>9} {:>9} {:<7} {:>10} {:>10} {:>8} {:>8}\n", "view", "size",
             "camera", "samples", "normals", "pose", "spacing", "noise", "n. deg", "bias deg");
  for (const Json& view : report["views"])
    fmt::print("{:<16} {:>11} {:<12} {:>9} {:>9} {:<7} {:>10} {:>10} {:>8} {:>8}\n",
               view["name"].get<std::string>(),
               fmt::format("{}x{}", view["width"].get<int>(), view["height"].get<int>()),
               view["camera"].get<std::string>(), view["samples"].get<std::size_t>(),
               view["normals"].get<std::size_t>(), view["pose"].get<std::string>(),
               figure(view, "spacing", "{:.4g}"), figure(view, "sigma_position", "{:.3g}"),
               figure(view, "sigma_normal_deg", "{:.2f}"),
               figure(view, "normal_bias_deg", "{:.2f}"));
  fmt::print(
      "spacing: median distance of neighbouring samples [{0}]; noise: of the range [{0}] and of "
      "the normals, estimated\n",
      report["unit"].get<std::string>());
}

int info(const InfoCommand& command) {
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  Json report = {{"unit", project->unit}, {"views", Json::array()}};
  for (const RangeView& view : project->views) report["views"].push_back(view_info(view));

  if (!command.common.json) print_table(report);
  if (command.common.json) std::cout << Json({{"info", report}}).dump(2) << "\n" << std::flush;
  if (!command.common.report.empty()) {
    CommonOptions silent = command.common;
    silent.json = false;
    const auto reported = write_report(command.common.report, "info", report, silent);
    if (!reported) return fail(reported.error());
  }
  return kDone;
}

}  // namespace

void add_info(CLI::App& app, Action& action) {
  auto command = std::make_shared<InfoCommand>();
  auto* sub =
      app.add_subcommand("info", "What is in a project: views, samples, spacing, normals, noise");
  add_project_input(*sub, command->input);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return info(*command); }; });
}

}  // namespace relief
