#include "apps/commands/command.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/interruption.h"
#include "apps/console/progress_display.h"
#include "apps/options/number_checks.h"
#include "relief/scan/static_background.h"

namespace relief {

namespace {

std::map<std::string, ProgressFormat> progress_formats() {
  return {{"auto", ProgressFormat::kAuto},
          {"bar", ProgressFormat::kBar},
          {"lines", ProgressFormat::kLines},
          {"json", ProgressFormat::kJson},
          {"off", ProgressFormat::kOff}};
}

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options) {
  auto* quiet = command.add_flag("-q,--quiet", options.quiet, "Only errors on standard error");
  command.add_flag("-v,--verbose", options.verbose, "More detail on standard error")
      ->excludes(quiet);
  command
      .add_option("--progress", options.progress,
                  "Progress on standard error: bar, lines, json (an object a line, messages as "
                  "well), off; auto: a bar on a terminal, else lines")
      ->transform(CLI::CheckedTransformer(progress_formats()))
      ->default_str("auto");
  command.add_flag("--json", options.json, "Print the report to standard output");
  command.add_option("--threads", options.threads, "Number of threads; 0: one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Seed of everything random")->capture_default_str();
  command.add_option("--report", options.report,
                     "File of the report instead of report.json beside the output");
  command.parse_complete_callback([&options] {
    Console::set_verbosity(options.quiet     ? Verbosity::kQuiet
                           : options.verbose ? Verbosity::kVerbose
                                             : Verbosity::kNormal);
    set_progress_format(options.progress);
  });
}

void add_project_input(CLI::App& command, ProjectInput& input) {
  command
      .add_option(
          "project", input.path,
          "scan.json, .conf, .aln, .mlp, a file of scans (.ply .pcd .ptx .e57 .xyz .pts .obj "
          ".stl .vtp), a folder of them or of depth maps, or a COLMAP workspace")
      ->required();
  add_reading_options(command, input.options);
}

void add_reading_options(CLI::App& command, ReadProjectOptions& options) {
  command.add_option("--fc", options.fc_file,
                     "Intrinsics of grids without a camera: a file with fx fy cx cy");
  command
      .add_option_function<std::vector<double>>(
          "--intrinsics",
          [&options](const std::vector<double>& k) {
            options.intrinsics = PinholeIntrinsics{k[0], k[1], k[2], k[3]};
          },
          "fx fy cx cy [pixels] of the depth maps of a folder without a scan.json")
      ->delimiter(',')
      ->expected(4);
  command
      .add_option(
          "--depth-scale", options.depth_scale,
          "Steps of such a depth map to the metre, as 1000 or 5000, or metres of a step, as 0.001")
      ->check(positive_number());
  command
      .add_option_function<std::vector<double>>(
          "--viewpoint",
          [&options](const std::vector<double>& p) {
            options.viewpoint = Eigen::Vector3d(p[0], p[1], p[2]);
          },
          "x y z of the sensor, for points and meshes without a grid; left out: it is found")
      ->expected(3);
  command.add_flag("--ignore-viewpoint", options.ignore_viewpoints,
                   "Do not take the poses that files of scans tell (PCD, PTX, E57)");
  command.add_flag("--shared-frame", options.shared_frame,
                   "Files of scans without poses are all in one frame, which is where alignment "
                   "starts");
  command.add_flag("--skip-damaged", options.skip_damaged,
                   "Go on without the views that cannot be read");
}

void add_background_option(CLI::App& command, ProjectInput& input) {
  input.look_for_background = true;
  command
      .add_option_function<std::string>(
          "--background",
          [&input](const std::string& what) { input.keep_background = what == "keep"; },
          "What stands still in the camera's frame while the object turns: auto (leave it out) or "
          "keep")
      ->check(CLI::IsMember({"auto", "keep"}))
      ->default_str("auto");
}

Result<ScanProject> read_with_notes(const ProjectInput& input, const CommonOptions& common,
                                    const ViewsRead& views_read) {
  auto project = read_project(input.path, input.options, context_of(common, "read"));
  if (!project) return project;
  if (views_read) views_read(project->views);
  if (input.look_for_background) {
    const StaticBackground background = find_static_background(project->views);
    if (!input.keep_background) remove_background(background, project->views);
    for (std::string& line : describe(background, !input.keep_background))
      project->notes.push_back(std::move(line));
  }
  std::size_t samples = 0, with_normals = 0;
  for (const RangeView& view : project->views) {
    samples += view.sample_count();
    with_normals += view.has_normals() ? 1 : 0;
  }
  for (const std::string& note : project->notes) Console::info(note);
  Console::info(input.path.string() + ": " + std::to_string(project->views.size()) + " views, " +
                std::to_string(samples) + " samples, " + std::to_string(with_normals) +
                " views with normals, unit " + project->unit);
  return project;
}

Context context_of(const CommonOptions& common, const std::string& stage) {
  Context context;
  context.seed = common.seed;
  context.progress = console_progress(stage);
  context.stop = interruption();
  return context;
}

int fail(const Error& error) {
  const bool late = error.kind == ErrorKind::kInterrupted && time_is_over();
  Console::error(late ? "the time limit is over" : error.message);
  return exit_status(error);
}

}  // namespace relief
