#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/reports/console.h"
#include "apps/reports/mesh_report.h"
#include "apps/stages/stages.h"
#include "relief/scan/static_background.h"
#include "scan/base/parallel.h"
#include "scan/base/stopwatch.h"
#include "scan/io/project/view_loader.h"

namespace relief {

namespace {

Json merge_report(const fusion::MergeResult& merged) {
  Json report = to_json(merged.check);
  report["filled_area_fraction"] = merged.filled_area_fraction;
  report["flying_samples"] = merged.flying_samples;
  report["filled_samples"] = merged.filled_samples;
  report["components_removed"] = merged.components_removed;
  report["faces_removed"] = merged.faces_removed;
  report["voxel_size"] = merged.voxel_size;
  report["truncation"] = merged.truncation;
  return report;
}

Json polish_report(const hybrid::PolishedMesh& polished) {
  return {{"status", to_string(polished.status)},
          {"vertices_with_normal", polished.with_normal},
          {"sigma_view_deg", polished.sigma_view * 180.0 / std::numbers::pi},
          {"rms_move", polished.rms_move},
          {"max_move", polished.max_move},
          {"vertices_damped", polished.damped},
          {"vertices_unmoved", polished.unmoved},
          {"rounds", polished.rounds},
          {"iterations", polished.iterations},
          {"seconds", polished.seconds}};
}

void log_polish(const hybrid::PolishedMesh& polished, const std::string& unit) {
  if (polished.status == hybrid::PolishStatus::kNotConverged)
    Console::warning("polishing did not converge: its last iterate is kept");
  if (polished.rounds == 0)
    Console::info(fmt::format("not polished: {}", to_string(polished.status)));
  else
    Console::info(fmt::format("polished: vertices moved {:.3g} {} RMS, {} held back, {:.1f} s",
                              polished.rms_move, unit, polished.damped, polished.seconds));
}

// Refines the merged mesh with the views' normals; moving the vertices changes its check, and what
// was closed must still be.
Result<Json> polish(const ScanProject& project, const hybrid::PolishOptions& options,
                    fusion::MergeResult& merged) {
  hybrid::PolishOptions scaled = options;
  release_freed_memory();  // What merging took.
  if (!(scaled.normals.max_distance > 0.0)) scaled.normals.max_distance = merged.truncation;
  auto polished =
      hybrid::polish_mesh(merged.mesh, project.views, scaled, console_progress("polish"));
  if (!polished) return polished.error();
  log_polish(*polished, project.unit);
  if (polished->rounds > 0) {
    const bool was_closed = merged.check.watertight();
    merged.mesh = std::move(polished->mesh);
    merged.check = check_mesh(merged.mesh);
    if (was_closed && !merged.check.watertight())
      return Error{ErrorKind::kUnsolvable,
                   "polishing left the surface no closed manifold; merge with --no-polish"};
  }
  return polish_report(*polished);
}

// Fewer faces, when the options ask for it.
Result<void> decimate(const fusion::DecimationOptions& options, fusion::MergeResult& merged) {
  if (options.faces == 0 && !(options.max_error > 0.0)) return {};
  auto decimated = fusion::decimate_mesh(merged.mesh, options);
  if (!decimated) return decimated.error();
  Console::info(fmt::format("decimated: {} of {} faces", decimated->mesh.faces.size(),
                            merged.mesh.faces.size()));
  merged.mesh = std::move(decimated->mesh);
  merged.check = decimated->check;
  return {};
}

fusion::MergeOptions merge_options_of(const MergeStageOptions& options) {
  fusion::MergeOptions merge_options = options.merge;
  merge_options.threads = options.threads;
  return merge_options;
}

// From the merged mesh to the end of the stage. `load` gives the project with its views when they
// are needed.
template <typename LoadProject>
Result<MergeStage> finish(Result<fusion::MergeResult> merged, const MergeStageOptions& options,
                          const Stopwatch& watch, const LoadProject& load) {
  if (!merged) return merged.error();
  for (const std::string& note : merged->notes) Console::info(note);

  Json polish_section;
  if (options.polish) {
    hybrid::PolishOptions polish_options = *options.polish;
    polish_options.threads = options.threads;
    const auto project = load(*merged);
    if (!project) return project.error();
    auto section = polish(**project, polish_options, *merged);
    if (!section) return section.error();
    polish_section = std::move(*section);
  }

  if (const auto done = decimate(options.decimation, *merged); !done) return done.error();

  MergeStage stage;
  stage.report = merge_report(*merged);
  if (options.polish) stage.report["polish"] = polish_section;
  stage.report["seconds"] = watch.seconds();
  stage.report["peak_memory_mb"] = peak_memory_mb();
  Console::info(
      fmt::format("merged: {} vertices, {} faces, {}, {:.1f} % of the area filled, {:.1f} s",
                  merged->check.vertices, merged->check.faces,
                  merged->check.watertight() ? "watertight" : "not watertight (holes kept)",
                  100.0 * merged->filled_area_fraction, stage.report["seconds"].get<double>()));
  stage.mesh = std::move(merged->mesh);
  return stage;
}

using SharedView = std::shared_ptr<const RangeView>;

// The views of a project, read one at a time.
class ProjectViews {
 public:
  ProjectViews(std::vector<ViewSpec> specs, std::vector<ChosenConvention> conventions,
               const StaticBackground& background)
      : specs_(std::move(specs)), conventions_(std::move(conventions)), background_(background) {}

  fusion::ViewSource source() {
    return {specs_.size(), [this](std::size_t i) { return load(i); }};
  }
  /// Of the largest view so far.
  std::size_t pixels() const { return pixels_; }

 private:
  Result<SharedView> load(std::size_t i) {
    auto loaded = load_view(specs_[i]);
    if (!loaded) return loaded.error();
    set_normals(*loaded, conventions_[i]);
    remove_background(background_.masks[i], loaded->view);
    if (i >= read_) {  // notes once
      for (const std::string& note : loaded->notes) Console::info(note);
      read_ = i + 1;
    }
    pixels_ = std::max(pixels_, loaded->view.range.size());
    return SharedView(std::make_shared<const RangeView>(std::move(loaded->view)));
  }

  std::vector<ViewSpec> specs_;
  std::vector<ChosenConvention> conventions_;
  const StaticBackground& background_;
  std::size_t read_ = 0, pixels_ = 0;
};

// What polishing holds: views [bytes a pixel], and the mesh, its graph and the system [bytes a
// vertex]; see docs/fusion.md.
constexpr std::size_t kViewPixel = 30, kPolishedVertex = 550;

Result<void> check_room_to_polish(const fusion::MergeResult& merged, std::size_t pixels,
                                  std::size_t limit) {
  const std::size_t needed = kViewPixel * pixels + kPolishedVertex * merged.mesh.vertices.size();
  if (needed <= limit) return {};
  return Error{ErrorKind::kUnsolvable,
               fmt::format("polishing needs about {} MiB, more than the memory limit of {} MiB: "
                           "raise the limit or merge with --no-polish",
                           needed >> 20, limit >> 20)};
}

// What the search for a background holds: ranges, depths, edges [bytes a pixel].
constexpr std::size_t kSearchedPixel = 24;

// The background of views that are read one at a time and of which only the ranges are kept.
// Nothing where these alone would exceed half of the limit.
Result<StaticBackground> find_background(const ProjectInput& input,
                                         const std::vector<ViewSpec>& specs,
                                         const MergeStageOptions& options) {
  StaticBackground none;
  none.masks.resize(specs.size());
  if (!input.look_for_background || input.keep_background) return none;
  std::vector<RangeView> views;
  std::size_t pixels = 0;
  for (const ViewSpec& spec : specs) {
    auto loaded = load_view(spec);
    if (!loaded) return loaded.error();
    RangeView view;
    view.camera = loaded->view.camera;
    view.range = std::move(loaded->view.range);
    view.world_from_view = loaded->view.world_from_view;
    view.pose = loaded->view.pose;
    pixels += view.range.size();
    views.push_back(std::move(view));
    if (2 * kSearchedPixel * pixels > options.merge.memory) {
      Console::warning(
          "background not looked for: the ranges of all views exceed half of the "
          "memory limit; raise it, or give the views masks");
      return none;
    }
  }
  StaticBackground found = find_static_background(views, options.threads);
  for (const std::string& line : describe(found, true)) Console::info(line);
  return found;
}

}  // namespace

Result<MergeStage> merge_stage(const ScanProject& project, const MergeStageOptions& options) {
  const Stopwatch watch;
  auto merged =
      fusion::merge_views(project.views, merge_options_of(options), console_progress("merge"));
  return finish(std::move(merged), options, watch,
                [&](const fusion::MergeResult&) { return Result<const ScanProject*>(&project); });
}

Result<MergeStage> merge_stage_within_limit(const ProjectInput& input,
                                            const MergeStageOptions& options) {
  const Stopwatch watch;
  auto spec = read_project_spec(input.path, input.options.fc_file);
  if (!spec) return spec.error();
  for (const std::string& note : spec->notes) Console::info(note);
  const std::size_t count = spec->views.size();
  auto conventions = find_conventions(spec->views);
  if (!conventions) return conventions.error();
  for (const std::string& note : conventions->notes) Console::info(note);
  auto background = find_background(input, spec->views, options);
  if (!background) return background.error();
  release_freed_memory();
  ProjectViews views(std::move(spec->views), std::move(conventions->views), *background);
  auto merged = fusion::merge_from_source(views.source(), merge_options_of(options),
                                          console_progress("merge"));
  ScanProject project;
  const auto load = [&](const fusion::MergeResult& mesh) -> Result<const ScanProject*> {
    const auto room = check_room_to_polish(mesh, count * views.pixels(), options.merge.memory);
    if (!room) return room.error();
    ReadProjectOptions read = input.options;
    read.threads = options.threads;
    auto all = read_project(input.path, read, console_progress("read"));
    if (!all) return all.error();
    project = std::move(*all);
    remove_background(*background, project.views);
    return &project;
  };
  return finish(std::move(merged), options, watch, load);
}

}  // namespace relief
