#include "relief/simulation/simulate.h"

#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/simulation_defects.h"
#include "apps/options/simulation_options.h"
#include "apps/options/simulation_record.h"
#include "apps/reports/report.h"
#include "relief/io/mesh_io.h"
#include "relief/io/project_io.h"
#include "relief/scan/mesh_check.h"
#include "relief/simulation/simulation_object.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

struct SimulateCommand {
  CommonOptions common;
  simulation::SimulationOptions options;
  SensorChoice sensors;
  DefectChoice defects;
  std::filesystem::path poses;  ///< Empty: a layout.
  std::filesystem::path mesh;   ///< Empty: the built-in object.
  std::string unit = "mm";
  std::filesystem::path output;
};

// What the simulated sensors did, and where they truly stood.
Json truth_record(const simulation::Simulation& simulation, const SimulateCommand& command) {
  Json record = simulation_record(simulation, command.options);
  const Json defects = defects_json(command.options.defects, command.defects.undeclared_normals);
  if (!defects.is_null()) record["defects"] = defects;
  record["views"] = Json::array();
  for (const RangeView& view : simulation.truth.views)
    record["views"].push_back(
        {{"name", view.name}, {"world_from_view", to_json(view.world_from_view)}});
  return record;
}

// The truth goes first, so that a scan.json never stands without it.
Result<void> write_simulation(const simulation::Simulation& simulation,
                              const SimulateCommand& command) {
  const auto& folder = command.output;
  if (auto done = prepare_folder(folder / "truth"); !done) return done;
  if (!simulation.mesh.faces.empty())
    if (auto done = write_mesh(simulation.mesh, folder / "truth/model.ply"); !done) return done;
  if (auto done =
          write_project(simulation.truth, folder / "truth", context_of(command.common, "write"));
      !done)
    return done;
  const Json record = truth_record(simulation, command);
  if (auto done = write_file(folder / "truth.json", record.dump(1) + "\n"); !done) return done;
  WriteProjectOptions writing;
  writing.declare_normals = !command.defects.undeclared_normals;
  return write_project(simulation.scans, folder, context_of(command.common, "write"), writing);
}

Result<simulation::SimulationObject> object_to_scan(const SimulateCommand& command) {
  if (command.mesh.empty())
    return simulation::built_in_simulation_object(command.options.mesh_divisions);
  auto mesh = read_mesh(command.mesh);
  if (!mesh) return mesh.error();
  if (!check_mesh(*mesh).closed())
    Console::warning(command.mesh.string() +
                     ": the mesh is not closed; scans see through where it is open");
  auto object = simulation::mesh_object(std::move(*mesh), command.unit);
  if (!object)
    return Error{object.error().kind, command.mesh.string() + ": " + object.error().message};
  return object;
}

Result<simulation::SimulationOptions> chosen_options(const SimulateCommand& command) {
  simulation::SimulationOptions options = command.options;
  options.seed = command.common.seed;
  if (auto applied = command.sensors.apply(options); !applied) return applied.error();
  auto defects = command.defects.chosen();
  if (!defects) return defects.error();
  options.defects = *defects;
  if (command.defects.undeclared_normals && options.rays != simulation::SensorRays::kPinhole)
    return Error{ErrorKind::kBadInput,
                 "--undeclared-normals has no meaning here; it needs --rays pinhole, whose normals "
                 "are maps of their own"};
  if (command.poses.empty()) return options;
  auto poses = read_poses(command.poses);
  if (!poses) return poses.error();
  options.poses = std::move(*poses);
  return options;
}

int simulate_scans(const SimulateCommand& command) {
  const auto chosen = chosen_options(command);
  if (!chosen) return fail(chosen.error());
  const simulation::SimulationOptions& options = *chosen;
  if (const auto ready = prepare_folder(command.output); !ready) return fail(ready.error());
  const auto object = object_to_scan(command);
  if (!object) return fail(object.error());
  const auto simulation =
      simulation::simulate(*object, options, context_of(command.common, "simulate"));
  if (!simulation) return fail(simulation.error());
  SimulateCommand used = command;
  used.options = options;
  if (const auto written = write_simulation(*simulation, used); !written)
    return fail(written.error());
  Console::info(fmt::format("wrote {}: {} views of {}x{}, spacing {:.3g} {}, range noise {:.3g} {}",
                            (command.output / "scan.json").string(), simulation->scans.views.size(),
                            options.width, options.height, simulation->spacing,
                            simulation->scans.unit, simulation->range_sigma,
                            simulation->scans.unit));
  return kDone;
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
  auto command = std::make_shared<SimulateCommand>();
  auto* sub = app.add_subcommand(
      "simulate", "Scans with normal maps of a mesh or the built-in object, with their truth");
  sub->add_option("mesh", command->mesh,
                  "Mesh to scan (.ply .obj .stl), faces outwards; default: the built-in object");
  sub->add_option("--unit", command->unit, "Unit of the mesh")->capture_default_str();
  sub->add_option("-o,--output", command->output,
                  "Folder for scan.json, truth.json and truth/ (exact views and mesh)")
      ->required();
  add_simulation_options(*sub, command->options);
  sub->add_option("--poses-from", command->poses,
                  "File with the poses of the views, in place of --views, --layout and --distance")
      ->check(CLI::ExistingFile);
  add_sensor_options(*sub, command->sensors);
  add_defect_options(*sub, command->defects);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return simulate_scans(*command); }; });
}

}  // namespace relief
