#include <algorithm>
#include <iostream>
#include <map>
#include <memory>

#include "apps/command.h"
#include "apps/console.h"
#include "apps/evaluation_report.h"
#include "apps/exit_status.h"
#include "apps/input_kind.h"
#include "apps/output.h"
#include "scan/io/atomic_file.h"
#include "scan/io/mesh_io.h"
#include "scan/io/poses_io.h"

namespace relief {

namespace {

struct EvaluateCommand {
  CommonOptions common;
  ProjectInput result;
  std::filesystem::path truth;
  MeshDistanceOptions mesh;
  std::filesystem::path output;
};

// The figures as JSON to standard output, to --report, and to report.json in the output folder.
Result<void> deliver(const EvaluateCommand& command, const Json& figures) {
  if (command.common.json) std::cout << Json({{"evaluate", figures}}).dump(2) << "\n" << std::flush;
  CommonOptions silent = command.common;
  silent.json = false;
  const bool to_file = !command.common.report.empty() || !command.output.empty();
  if (!to_file) return {};
  return write_report(report_path(silent, command.output / "errors.ply"), "evaluate", figures,
                      silent);
}

// The result with its signed distance to the truth as quality.
Result<void> write_errors(const EvaluateCommand& command, TriangleMesh result,
                          const TriangleMesh& truth) {
  const auto distances = signed_distances(result, truth, command.common.threads);
  result.quality.assign(distances.begin(), distances.end());
  const auto file = command.output / "errors.ply";
  if (auto written = write_mesh(result, file); !written) return written;
  Console::info("wrote " + file.string() + ": signed distances as quality");
  return {};
}

Result<void> evaluate_mesh(const EvaluateCommand& command) {
  const auto result = read_mesh(command.result.path);
  if (!result) return result.error();
  const auto truth = read_mesh(command.truth);
  if (!truth) return truth.error();
  MeshDistanceOptions options = command.mesh;
  options.threads = command.common.threads;
  options.seed = command.common.seed;
  const auto comparison = compare_meshes(*result, *truth, options, console_progress("evaluate"));
  if (!comparison) return comparison.error();

  const MeshCheck check =
      check_mesh(*result, {.self_intersections = true, .threads = command.common.threads});
  if (!command.common.json) print_table(*comparison, check, "");
  if (!command.output.empty())
    if (auto written = write_errors(command, *result, *truth); !written) return written;
  return deliver(command, to_json(*comparison, check));
}

// The samples of `result` under the true poses of a file that holds poses only.
Result<ScanProject> truth_from_poses(const ScanProject& result, const std::filesystem::path& file) {
  const auto poses = read_poses(file);
  if (!poses) return poses.error();
  std::map<std::string, RigidMotion> by_name;
  for (const NamedPose& pose : *poses) by_name.emplace(pose.name, pose.world_from_view);
  ScanProject truth = result;
  for (RangeView& view : truth.views) {
    const auto found = by_name.find(view.name);
    if (found == by_name.end())
      return Error{ErrorKind::kBadInput, file.string() + ": has no pose for view " + view.name};
    view.world_from_view = found->second;
    view.pose = PoseKind::kKnown;
  }
  return truth;
}

// Whether a JSON file is more than a list of poses.
bool holds_views(const std::filesystem::path& path) {
  if (path.extension() != ".json") return true;
  const auto text = read_file(path);
  return !text || text->find("relief-scan") != std::string::npos;
}

bool have_poses(const ScanProject& project) {
  return std::all_of(project.views.begin(), project.views.end(),
                     [](const RangeView& view) { return view.pose != PoseKind::kAbsent; });
}

Result<void> evaluate_project(const EvaluateCommand& command) {
  const auto result = read_with_notes(command.result, command.common);
  if (!result) return result.error();
  const bool with_views = holds_views(command.truth);
  ProjectInput truth_input{command.truth, command.result.options};
  const auto truth = with_views ? read_with_notes(truth_input, command.common)
                                : truth_from_poses(*result, command.truth);
  if (!truth) return truth.error();

  Json figures = Json::object();
  if (with_views) {
    const auto views = evaluate_views(*result, *truth, {.threads = command.common.threads});
    if (!views) return views.error();
    figures = to_json(*views);
    if (!command.common.json) print_table(*views, result->unit);
  }
  if (result->views.size() > 1 && have_poses(*result)) {
    const auto poses = evaluate_poses(*result, *truth);
    if (!poses) return poses.error();
    figures["poses"] = to_json(*poses);
    if (!command.common.json) print_table(*poses, result->unit);
  }
  return deliver(command, figures);
}

int evaluate(const EvaluateCommand& command) {
  if (!command.output.empty())
    if (const auto ready = prepare_folder(command.output); !ready) return fail(ready.error());
  const auto done = is_triangle_mesh_file(command.result.path) ? evaluate_mesh(command)
                                                               : evaluate_project(command);
  return done ? kDone : fail(done.error());
}

}  // namespace

void add_evaluate(CLI::App& app, Action& action) {
  auto command = std::make_shared<EvaluateCommand>();
  auto* sub = app.add_subcommand("evaluate", "Errors of a mesh, of views or of poses");
  sub->add_option("result", command->result.path, "A mesh, or a project")->required();
  sub->add_option("--fc", command->result.options.fc_file,
                  "Intrinsics of grids without a camera: a file with fx fy cx cy");
  sub->add_option("--truth", command->truth,
                  "A mesh for a mesh; for a project, the true project or a file of true poses")
      ->required();
  sub->add_option("--threshold", command->mesh.thresholds,
                  "Distances of the F-score; default: multiples of the spacing");
  sub->add_option("--samples", command->mesh.samples, "Points on each mesh")->capture_default_str();
  sub->add_option("-o,--output", command->output,
                  "Folder for report.json and errors.ply, the mesh with its signed errors");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return evaluate(*command); }; });
}

}  // namespace relief
