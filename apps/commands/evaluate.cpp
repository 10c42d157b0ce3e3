#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/input_kind.h"
#include "apps/options/number_checks.h"
#include "apps/reports/evaluation/evaluation_plots.h"
#include "apps/reports/evaluation/evaluation_report.h"
#include "relief/evaluation/mesh_errors.h"
#include "relief/io/mesh_io.h"
#include "relief/io/project_io.h"
#include "scan/evaluation/base/angles.h"
#include "scan/evaluation/base/error_colours.h"
#include "scan/io/meshes/coloured_mesh.h"
#include "scan/io/project/poses/poses_of_views.h"

namespace relief {

namespace {

struct EvaluateCommand {
  CommonOptions common;
  ProjectInput result;
  std::filesystem::path truth;
  evaluation::MeshDistanceOptions mesh;
  bool align = false;
  double colour_scale = 0.0;  ///< Error of full colour [unit]; 0: that of 95 % of the surface.
  std::filesystem::path output, plots;
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

// A mesh with the distances of its vertices to `other` as quality and as colours.
Result<void> write_errors(TriangleMesh mesh, const TriangleMesh& other, bool with_sign,
                          double scale, const std::filesystem::path& file) {
  auto distances = evaluation::signed_distances(mesh, other);
  if (!with_sign)
    for (double& distance : distances) distance = std::abs(distance);
  mesh.quality.assign(distances.begin(), distances.end());
  const std::string comment = fmt::format(
      "quality: distance to the other surface{}; colours: blue {:.6g}, grey 0, red {:.6g}",
      with_sign ? ", negative inside" : "", -scale, scale);
  auto written =
      write_coloured_mesh(mesh, evaluation::colours_of_errors(distances, scale), comment, file);
  if (written) Console::info("wrote " + file.string() + ": " + comment);
  return written;
}

Result<void> write_both_errors(const EvaluateCommand& command, const TriangleMesh& result,
                               const TriangleMesh& truth, double scale) {
  if (auto done = write_errors(result, truth, true, scale, command.output / "errors.ply"); !done)
    return done;
  return write_errors(truth, result, false, scale, command.output / "completeness.ply");
}

// Brings the result into the frame of the truth and notes how.
Result<void> move_to_truth(const EvaluateCommand& command, const TriangleMesh& truth,
                           TriangleMesh& result, Json& figures) {
  const auto fit =
      evaluation::align_mesh(result, truth, {}, context_of(command.common, "evaluate"));
  if (!fit) return fit.error();
  for (auto& vertex : result.vertices) vertex = fit->truth_from_result * vertex;
  const Eigen::Matrix3f rotation = fit->truth_from_result.linear().cast<float>();
  for (auto& normal : result.normals) normal = rotation * normal;
  figures["alignment"] = {{"truth_from_result", to_json(fit->truth_from_result)},
                          {"median_distance", fit->median_distance},
                          {"iterations", fit->iterations},
                          {"converged", fit->converged}};
  if (!fit->converged) Console::warning("the alignment with the truth did not settle");
  if (!command.common.json)
    fmt::print("aligned: the result was turned by {:.4g} deg and moved\n",
               evaluation::degrees(rotation_angle(fit->truth_from_result)));
  return {};
}

Result<void> evaluate_mesh(const EvaluateCommand& command) {
  auto result = read_mesh(command.result.path);
  if (!result) return result.error();
  const auto truth = read_mesh(command.truth);
  if (!truth) return truth.error();
  Json alignment = Json::object();
  if (command.align)
    if (auto moved = move_to_truth(command, *truth, *result, alignment); !moved) return moved;
  const auto comparison = evaluation::compare_meshes(*result, *truth, command.mesh,
                                                     context_of(command.common, "evaluate"));
  if (!comparison) return comparison.error();

  const MeshCheck check = check_mesh(*result, {.self_intersections = true});
  if (!command.common.json) print_table(*comparison, check, "");
  const double p95 = comparison->accuracy.all.distance.p95;
  const double scale = command.colour_scale > 0.0 ? command.colour_scale : p95 > 0.0 ? p95 : 1.0;
  Json figures = to_json(*comparison, check);
  figures["colour_scale"] = scale;
  figures.update(alignment);
  if (auto delivered = deliver(command, figures); !delivered) return delivered;
  if (!command.output.empty())
    if (auto written = write_both_errors(command, *result, *truth, scale); !written) return written;
  return command.plots.empty() ? Result<void>() : plot_distances(*comparison, "", command.plots);
}

// The samples of `result` under the true poses of a file that holds poses only.
Result<ScanProject> truth_from_poses(const ScanProject& result, const std::filesystem::path& file) {
  std::vector<std::string> names, notes;
  for (const RangeView& view : result.views) names.push_back(view.name);
  const auto poses = read_poses_of_views(file, names, notes);
  if (!poses) return poses.error();
  for (const std::string& note : notes) Console::info(note);
  ScanProject truth = result;
  for (std::size_t i = 0; i < truth.views.size(); ++i) {
    truth.views[i].world_from_view = (*poses)[i];
    truth.views[i].pose = PoseKind::kKnown;
  }
  return truth;
}

bool have_poses(const ScanProject& project) {
  return std::all_of(project.views.begin(), project.views.end(),
                     [](const RangeView& view) { return view.pose != PoseKind::kAbsent; });
}

Result<void> plot_views(const evaluation::ViewSpectra& spectra, const ScanProject& result,
                        const ScanProject& truth, const std::filesystem::path& folder) {
  if (auto done = plot_spectra(spectra, result.unit, folder); !done) return done;
  const auto pairs = evaluation::pair_views(result, truth);
  if (!pairs) return pairs.error();
  for (const evaluation::ViewAndTruth& pair : *pairs)
    if (auto done = plot_error_maps(evaluation::error_maps(pair), result.unit, folder); !done)
      return done;
  return {};
}

Result<void> evaluate_project(const EvaluateCommand& command) {
  const auto result = read_with_notes(command.result, command.common);
  if (!result) return result.error();
  const bool with_views = !holds_poses_alone(command.truth);
  ProjectInput truth_input{command.truth, command.result.options};
  const auto truth = with_views ? read_with_notes(truth_input, command.common)
                                : truth_from_poses(*result, command.truth);
  if (!truth) return truth.error();

  Json figures = Json::object();
  std::optional<evaluation::ViewSpectra> spectra;
  if (with_views) {
    const Context context = context_of(command.common, "evaluate");
    const auto views = evaluation::evaluate_views(*result, *truth, {}, context);
    if (!views) return views.error();
    auto by_frequency = evaluation::evaluate_spectra(*result, *truth, {}, context);
    if (!by_frequency) return by_frequency.error();
    spectra = *std::move(by_frequency);
    figures = to_json(*views);
    figures["spectra"] = to_json(*spectra);
    if (!command.common.json) {
      print_table(*views, result->unit);
      print_table(*spectra, result->unit);
    }
  }
  if (!with_views || (result->views.size() > 1 && have_poses(*result))) {
    const auto poses = evaluation::evaluate_poses(*result, *truth);
    if (!poses) return poses.error();
    figures["poses"] = to_json(*poses);
    if (!command.common.json) print_table(*poses, result->unit);
  }
  if (auto delivered = deliver(command, figures); !delivered) return delivered;
  if (command.plots.empty() || !spectra) return {};
  return plot_views(*spectra, *result, *truth, command.plots);
}

int evaluate(const EvaluateCommand& command) {
  for (const auto& folder : {command.output, command.plots})
    if (!folder.empty())
      if (const auto ready = prepare_folder(folder); !ready) return fail(ready.error());
  const auto done = is_triangle_mesh_file(command.result.path) ? evaluate_mesh(command)
                                                               : evaluate_project(command);
  return done ? kDone : fail(done.error());
}

}  // namespace

void add_evaluate(CLI::App& app, Action& action) {
  auto command = std::make_shared<EvaluateCommand>();
  auto* sub = app.add_subcommand("evaluate", "Errors of a mesh, of views or of poses");
  sub->add_option("result", command->result.path, "A mesh, or a project")->required();
  add_reading_options(*sub, command->result.options);
  sub->add_option("--truth", command->truth,
                  "A mesh for a mesh; for a project, the true project or a file of true poses: "
                  "JSON, .tum, .log, a text or table of poses, .npy")
      ->required();
  sub->add_option("--thresholds,--threshold", command->mesh.thresholds,
                  "Distances of the F-score; default: multiples of the spacing");
  sub->add_flag("--align", command->align,
                "Meshes: fit the result to the truth by a rigid motion first, from any pose");
  sub->add_option("--samples", command->mesh.samples, "Points on each mesh")->capture_default_str();
  sub->add_option(
      "-o,--output", command->output,
      "Folder for report.json and, of meshes, errors.ply and completeness.ply, coloured");
  sub->add_option("--colour-scale", command->colour_scale,
                  "Error that has full colour; default: that of 95 % of the surface")
      ->check(positive_number());
  sub->add_option("--plots", command->plots,
                  "Folder for plots by gnuplot, and their data: distances and histogram of meshes, "
                  "spectra and error images of views");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return evaluate(*command); }; });
}

}  // namespace relief
