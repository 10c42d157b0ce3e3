#include <algorithm>
#include <cstdint>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/reports/report.h"
#include "hybrid/noise/noise.h"
#include "relief/scan/discontinuities.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"

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
    for (int u = 0; u < view.width(); ++u)
      count += view.has_sample(u, v) && view.has_normal(u, v) ? 1 : 0;
  return count;
}

// Samples that neighbourhoods of 5 x 5 samples of one surface surround.
std::size_t inner_count(const RangeView& view, const GridEdges& edges) {
  const Grid<std::uint8_t> boundary = boundary_distance(view, edges);
  return static_cast<std::size_t>(
      std::count_if(boundary.begin(), boundary.end(), [](std::uint8_t d) { return d >= 2; }));
}

// What the ranges alone show, in figures and in words.
void add_range_noise(const RangeView& view, const std::string& unit, Json& info) {
  const RangeNoise noise = estimate_range_noise(view);
  info["range_noise"] = describe(noise, view, unit);
  if (noise.known()) info["sigma_range"] = noise.sigma;
  if (noise.quantisation.step > 0.0) info["range_step"] = noise.quantisation.step;
  if (noise.quantisation.inverse_step > 0.0)
    info["inverse_range_step"] = noise.quantisation.inverse_step;
}

Json view_info(const RangeView& view, const std::string& unit) {
  const GridEdges edges = connect_samples(view);
  Json info = {{"name", view.name},
               {"width", view.width()},
               {"height", view.height()},
               {"camera", to_string(view.camera.model())},
               {"projects", view.camera.can_project()},
               {"samples", view.sample_count()},
               {"refined", view.samples == SampleOrigin::kRefined},
               {"normals", normal_count(view)},
               {"confidence", !view.confidence.empty()},
               {"colour", !view.colours.empty()},
               {"deviation", !view.deviation.empty()},
               {"pose", to_string(view.pose)},
               {"spacing", sample_spacing(points_of(view), edges)},
               {"inner_samples", inner_count(view, edges)}};
  add_range_noise(view, unit, info);
  if (!view.has_normals()) return info;
  const hybrid::NoiseEstimate noise = hybrid::estimate_noise(view, edges);
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

void print_range_noise(const Json& report) {
  fmt::print("ranges by themselves:\n");
  for (const Json& view : report["views"])
    fmt::print("  {:<16} {}\n", view["name"].get<std::string>(),
               view["range_noise"].get<std::string>());
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
  print_range_noise(report);
}

int info(const InfoCommand& command) {
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  Json report = {{"unit", project->unit}, {"views", Json::array()}};
  for (const RangeView& view : project->views)
    report["views"].push_back(view_info(view, project->unit));

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
  command->input.options.for_alignment = true;
  add_background_option(*sub, command->input);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return info(*command); }; });
}

}  // namespace relief
