#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <Eigen/Core>

#include "relief/io/project_io.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/parallel.h"
#include "scan/base/system/system_memory.h"
#include "scan/io/files/io_error.h"
#include "scan/io/project/loading/clipped_ranges.h"
#include "scan/io/project/loading/copied_views.h"
#include "scan/io/project/loading/settled_views.h"
#include "scan/io/project/loading/view_loader.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

using LoadedViews = std::vector<std::optional<Result<LoadedView>>>;

// Under a memory limit all views may take what the disk has left, as they lie in files. One view is
// decoded in the memory that is free, which holds all views where there is no limit.
MemoryBudget room_for_views() {
  const std::size_t free = free_memory();
  const MemoryLimit* const limit = current_memory_limit();
  if (!limit) return MemoryBudget(free);
  std::error_code unknown;
  const auto disk = std::filesystem::space(limit->folder(), unknown);
  return unknown ? MemoryBudget(free) : MemoryBudget(disk.available, free);
}

// One error that names all views that cannot be read, of `count`.
Error all_damaged(const std::vector<Error>& errors, std::size_t count) {
  constexpr std::size_t kNamed = 20;  // More files are damaged in the same way.
  if (count == errors.size()) return errors.front();
  if (errors.size() == 1)
    return {errors.front().kind, errors.front().message + "; --skip-damaged goes on without it"};
  std::string message = std::to_string(errors.size()) + " of " + std::to_string(count) +
                        " views cannot be read; --skip-damaged goes on without them:";
  for (std::size_t i = 0; i < std::min(kNamed, errors.size()); ++i)
    message += "\n  " + errors[i].message;
  if (errors.size() > kNamed) message += "\n  and more";
  return {errors.front().kind, message};
}

// Reads all views in parallel; those after an interruption stay empty.
LoadedViews load_views(const std::vector<ViewSpec>& specs, const ReadProjectOptions& options,
                       const Progress& progress, std::atomic<bool>& interrupted) {
  MemoryBudget memory = options.memory > 0 ? MemoryBudget(options.memory) : room_for_views();
  LoadedViews loaded(specs.size());
  std::atomic<std::size_t> done{0};
  const auto caller = std::this_thread::get_id();
  parallel_for(specs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !interrupted; ++i) {
      loaded[i].emplace(load_view(specs[i], memory));
      const double fraction = static_cast<double>(++done) / static_cast<double>(specs.size());
      if (std::this_thread::get_id() == caller &&
          !report_progress(progress, fraction, "reading views"))
        interrupted = true;
    }
  });
  return loaded;
}

// All views that can be read, unless some cannot and are not to be left out.
Result<std::vector<LoadedView>> readable_views(LoadedViews loaded, bool skip_damaged,
                                               std::vector<std::string>& notes) {
  std::vector<LoadedView> views;
  std::vector<Error> damaged;
  for (auto& view : loaded) {
    if (view->ok())
      views.push_back(std::move(**view));
    else
      damaged.push_back(view->error());
  }
  if (damaged.empty()) return views;
  if (!skip_damaged || views.empty()) return all_damaged(damaged, loaded.size());
  for (const Error& error : damaged) notes.push_back("a view is left out: " + error.message);
  return views;
}

ViewSpec& spec_of(const LoadedView& view, std::vector<ViewSpec>& specs) {
  return *std::ranges::find(specs, view.view.name, &ViewSpec::name);
}

// Settles together from where clouds were seen, and tells the project.
void settle_viewpoints(std::vector<ViewSpec>& specs, std::vector<LoadedView>& views,
                       ScanProject& project) {
  std::vector<AssumedViewpoint> viewpoints;
  for (const LoadedView& view : views)
    viewpoints.push_back(view.assumed_viewpoint == AssumedViewpoint::kNone
                             ? AssumedViewpoint::kNone
                             : viewpoint_in_set(spec_of(view, specs), view));
  for (const std::size_t i : views_to_see_from_origin(viewpoints))
    see_from_origin(spec_of(views[i], specs), views[i]);
  for (const LoadedView& view : views)
    if (view.assumed_viewpoint == AssumedViewpoint::kOrigin)
      project.seen_from_origin.push_back(view.view.name);
}

// A pose that all files tell alike is not taken.
void settle_poses(std::vector<ViewSpec>& specs, std::vector<LoadedView>& views,
                  ScanProject& project) {
  std::vector<std::optional<RigidMotion>> poses;
  for (const LoadedView& view : views) poses.push_back(pose_of_file(spec_of(view, specs), view));
  if (!is_constant(poses)) return;
  for (LoadedView& view : views) {
    view.view.world_from_view = RigidMotion::Identity();
    view.view.pose = PoseKind::kAbsent;
  }
  project.notes.push_back(
      "the files of all " + std::to_string(views.size()) +
      " views tell one and the same pose, as a turn of the axes that is in each file: it is not "
      "taken; if the points of all files lie in one frame, give --shared-frame");
}

// Settles the conventions of all normals together and gives the views their normals.
Result<std::vector<std::string>> settle_normals(std::vector<LoadedView>& views) {
  std::vector<NormalEvidence> evidence;
  for (const LoadedView& loaded : views)
    if (loaded.normals) evidence.push_back(loaded.normals->evidence);
  auto choice = choose_conventions(evidence);
  if (!choice) return choice.error();
  auto chosen = choice->views.begin();
  for (LoadedView& loaded : views)
    if (loaded.normals) set_normals(loaded, *chosen++);
  return std::move(choice->notes);
}

// Whether scans without poses were seen from sides that no one sensor's frame holds: more than a
// quarter turn apart. Only of those seen along parallel rays: others have a viewpoint of their own.
bool seem_to_share_a_frame(const std::vector<RangeView>& views) {
  std::vector<Eigen::Vector3d> directions;
  for (const RangeView& view : views) {
    const Eigen::Vector3d middle =
        view.camera.ray(view.width() / 2, view.height() / 2).direction.normalized();
    const bool parallel = middle.isApprox(view.camera.ray(0, 0).direction.normalized(), 1e-6);
    if (view.pose == PoseKind::kAbsent && parallel) directions.push_back(middle);
  }
  for (const auto& first : directions)
    for (const auto& second : directions)
      if (first.dot(second) < 0.0) return true;
  return false;
}

// Of views with a pinhole, how many have their principal point in the outer half of their pixels.
// The intrinsics of an image of another size put it there, and so does a crop.
std::optional<std::string> note_on_principal_points(const std::vector<ViewSpec>& specs,
                                                    const std::vector<RangeView>& views) {
  const auto find = [&](const RangeView& view) {
    const auto spec = std::ranges::find(specs, view.name, &ViewSpec::name);
    const bool pinhole =
        spec != specs.end() && spec->camera && spec->camera->model == CameraSpec::Model::kPinhole;
    return pinhole ? &spec->camera->intrinsics : nullptr;
  };
  const auto is_outer = [](double at, int size) {
    return std::abs(at - 0.5 * (size - 1)) > 0.25 * size;
  };
  const RangeView* first = nullptr;
  std::size_t outer = 0;
  for (const RangeView& view : views) {
    const PinholeIntrinsics* const pinhole = find(view);
    if (!pinhole || !(is_outer(pinhole->cx, view.width()) || is_outer(pinhole->cy, view.height())))
      continue;
    if (!first) first = &view;
    ++outer;
  }
  if (!first) return std::nullopt;
  std::ostringstream note;
  note << "the principal points of " << outer << " of " << views.size()
       << " views lie far from the middle of their images, as (" << find(*first)->cx << ", "
       << find(*first)->cy << ") of " << first->width() << " x " << first->height() << " pixels in "
       << first->name
       << ": unless the images are cropped, the intrinsics are those of another size";
  return note.str();
}

Result<void> check_shared_frame(const ProjectSpec& spec, const ReadProjectOptions& options,
                                const std::filesystem::path& path) {
  const bool used = std::any_of(spec.views.begin(), spec.views.end(), [](const ViewSpec& view) {
    return view.grid_options.shared_frame;
  });
  if (!options.shared_frame || used) return {};
  return bad_input(path,
                   "--shared-frame is for files of points and meshes without poses; a scan.json "
                   "tells the pose of a view by world_from_view");
}

}  // namespace

Result<ScanProject> read_project(const std::filesystem::path& path,
                                 const ReadProjectOptions& options, const Context& context) {
  return run_in(context, [&]() -> Result<ScanProject> {
    auto spec = read_project_spec(path, options);
    if (!spec) return spec.error();
    if (const auto used = check_shared_frame(*spec, options, path); !used) return used.error();
    std::atomic<bool> interrupted{false};
    LoadedViews loaded = load_views(spec->views, options, context.progress, interrupted);
    ScanProject project;
    project.unit = spec->unit;
    project.notes = spec->notes;
    if (interrupted)
      return Error{ErrorKind::kInterrupted, path.string() + ": reading was interrupted"};
    auto views = readable_views(std::move(loaded), options.skip_damaged, project.notes);
    if (!views) return views.error();
    settle_viewpoints(spec->views, *views, project);
    if (options.for_alignment) settle_poses(spec->views, *views, project);
    const auto notes = settle_normals(*views);
    if (!notes) return notes.error();
    std::vector<ClippedRanges> clipped;
    for (LoadedView& view : *views) {
      if (view.clipped) clipped.push_back(std::move(*view.clipped));
      project.views.push_back(std::move(view.view));
      for (auto& note : view.notes) project.notes.push_back(std::move(note));
    }
    project.notes.insert(project.notes.end(), notes->begin(), notes->end());
    if (auto note = note_on_principal_points(spec->views, project.views))
      project.notes.push_back(std::move(*note));
    if (auto note = note_on_clipped_ranges(clipped, project.views.size()))
      project.notes.push_back(std::move(*note));
    for (std::string& note :
         options.for_alignment ? leave_out_copies(project.views) : notes_on_copies(project.views))
      project.notes.push_back(std::move(note));
    if (seem_to_share_a_frame(project.views))
      project.notes.push_back(
          "the scans have no poses, but were seen from sides that are more than 90 degrees apart: "
          "if they lie in one frame, as after an alignment elsewhere, give --shared-frame");
    return project;
  });
}

}  // namespace relief
