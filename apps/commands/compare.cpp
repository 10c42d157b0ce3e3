#include <iostream>
#include <memory>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/number_checks.h"
#include "apps/reports/comparison/comparison_page.h"
#include "apps/reports/comparison/comparison_report.h"
#include "apps/version.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

struct CompareCommand {
  CommonOptions common;
  std::filesystem::path a, b;
  RunComparisonOptions options;
  std::filesystem::path page;    // Empty: none.
  std::filesystem::path models;  // Folder; empty: none.
};

// The figures as JSON to standard output or as tables, and to --report.
Result<void> deliver(const CompareCommand& command, const RunComparison& comparison) {
  const Json figures = to_json(comparison);
  if (command.common.json)
    std::cout << Json({{"relief", kVersion}, {"comparison", figures}}).dump(2) << "\n"
              << std::flush;
  else
    print_tables(comparison);
  if (command.common.report.empty()) return {};
  CommonOptions silent = command.common;
  silent.json = false;
  return write_report(command.common.report, "comparison", figures, silent);
}

Result<void> write_pictures(const CompareCommand& command, const RunComparison& comparison) {
  if (command.page.empty() && command.models.empty()) return {};
  std::vector<ReportPicture> pictures;
  if (comparison.models) {
    const VertexDistances distances = vertex_distances(*comparison.models);
    if (!command.models.empty())
      if (auto written = write_distance_models(*comparison.models, distances, command.models);
          !written)
        return written;
    if (!command.page.empty()) {
      auto drawn = pictures_of_models(*comparison.models, distances, comparison.unit);
      if (!drawn) return drawn.error();
      pictures = std::move(*drawn);
    }
  }
  if (command.page.empty()) return {};
  auto written = write_file(command.page, comparison_page(comparison, pictures));
  if (written) Console::info("wrote " + command.page.string());
  return written;
}

int compare(const CompareCommand& command) {
  if (!command.page.empty())
    if (const auto ready = prepare_folder_of(command.page); !ready) return fail(ready.error());
  if (!command.models.empty())
    if (const auto ready = prepare_folder(command.models); !ready) return fail(ready.error());
  auto a = read_run_folder(command.a);
  if (!a) return fail(a.error());
  auto b = read_run_folder(command.b);
  if (!b) return fail(b.error());
  const auto comparison = compare_runs(std::move(*a), std::move(*b), command.options,
                                       context_of(command.common, "compare"));
  if (!comparison) return fail(comparison.error());
  // The tables have them, too.
  if (command.common.json)
    for (const std::string& note : comparison->notes) Console::warning(note);
  if (const auto done = deliver(command, *comparison); !done) return fail(done.error());
  if (const auto done = write_pictures(command, *comparison); !done) return fail(done.error());
  return comparison->complete() ? kDone : kDataDoesNotAllow;
}

}  // namespace

void add_compare(CLI::App& app, Action& action) {
  auto command = std::make_shared<CompareCommand>();
  auto* sub = app.add_subcommand("compare", "Two runs side by side");
  sub->add_option("a", command->a, "Output folder of `relief run`")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("b", command->b, "Output folder of another run")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("-o,--output", command->page, "The page with tables and pictures, as FILE.html");
  sub->add_option("--models", command->models,
                  "Folder for a.ply and b.ply, coloured by their distance to each other");
  sub->add_flag_callback(
      "--no-align", [command] { command->options.align = false; },
      "Take both frames as one; otherwise B is brought into the frame of A by the poses of the "
      "views that both runs placed");
  sub->add_option("--samples", command->options.distances.samples, "Points on each model")
      ->check(positive_number())
      ->capture_default_str();
  sub->add_option("--thresholds,--threshold", command->options.distances.thresholds,
                  "Distances whose shares of the surface are told; default: multiples of the "
                  "edge length");
  sub->add_option("--colour-scale", command->options.colour_scale,
                  "Distance that has full colour; default: that of 95 % of the surfaces")
      ->check(positive_number());
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return compare(*command); }; });
}

}  // namespace relief
