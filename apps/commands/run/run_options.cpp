#include "apps/commands/run/run_options.h"

#include <map>

#include "apps/commands/convert/export_views.h"
#include "apps/options/number_checks.h"

namespace relief {

namespace {

reconstruction::ContradictedRanges contradicted_ranges(const std::string& word) {
  using reconstruction::ContradictedRanges;
  if (word == "keep") return ContradictedRanges::kKeep;
  return word == "weigh" ? ContradictedRanges::kWeigh : ContradictedRanges::kCorrect;
}

}  // namespace

reconstruction::ReconstructionOptions RunOptions::reconstruction() const {
  reconstruction::ReconstructionOptions options;
  options.remove_background = false;  // read_with_notes() did.
  options.align = align;
  options.calibration = calibration;
  options.contradicted = contradicted;
  options.refine = refine.resolved();
  options.model = merge.resolved();
  return options;
}

Outputs RunOptions::outputs() const {
  Outputs outputs{output, exports};
  outputs.files.push_back(output / "model.ply");
  outputs.files.push_back(report_path(common, output / "scan.json"));
  if (!no_html_report) outputs.files.push_back(output / "report.html");
  return outputs;
}

Context RunOptions::context(UnitStore* store) const {
  Context context = context_of(common, "").with_progress({});
  context.store = store;
  return context;
}

void add_run_options(CLI::App& command, RunOptions& options) {
  add_project_input(command, options.input);
  options.input.options.for_alignment = true;
  add_background_option(command, options.input);
  command
      .add_option(
          "-o,--output", options.output,
          "Folder for model.ply, the refined project (scan.json), report.json and report.html")
      ->required();
  add_export_option(command, options.exports);
  add_align_options(command, options.align);
  add_calibration_options(command, options.calibration);
  command
      .add_option_function<std::string>(
          "--contradicted",
          [&options](const std::string& what) { options.contradicted = contradicted_ranges(what); },
          "Ranges that several other views contradict: correct (they count less, and those far off "
          "move onto the surface of the other views), weigh (they count less) or keep")
      ->check(CLI::IsMember({"correct", "weigh", "keep"}))
      ->default_str("correct");
  add_refine_options(command, options.refine);
  add_merge_options(command, options.merge);
  add_memory_option(command, options.memory,
                    "fewer views are refined at once, large fields lie in temporary files in DIR");
  add_cache_options(command, options.cache);
  command
      .add_option("--time-limit", options.time_limit,
                  "Stop after this time, as 90s, 30min or 2h; the same command goes on from there")
      ->transform(CLI::AsNumberWithUnit(
          std::map<std::string, double>{{"s", 1.0}, {"min", 60.0}, {"h", 3600.0}}))
      ->check(positive_number());
  command.add_flag("--no-html-report", options.no_html_report, "Do not write report.html");
  add_html_report_options(command, options.html);
  add_common_options(command, options.common);
}

}  // namespace relief
