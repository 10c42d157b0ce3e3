#include "scan/io/project/guess/folder_guess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "scan/base/parallel.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_size.h"
#include "scan/io/project/guess/image_names.h"
#include "scan/io/project/json/spec_json_private.h"
#include "scan/io/project/loading/view_loader.h"
#include "scan/io/project/poses/poses_of_scans.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/pose_beside.h"
#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"
#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"
#include "scan/io/workspaces/rgbd/agreement/pose_scale.h"
#include "scan/io/workspaces/rgbd/agreement/ray_lengths.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

CameraSpec unknown_camera(const fs::path& depth) {
  CameraSpec camera;
  if (const auto size = image_size(depth)) {
    camera.width = size->width;
    camera.height = size->height;
    camera.intrinsics.cx = 0.5 * (size->width - 1);
    camera.intrinsics.cy = 0.5 * (size->height - 1);
  }
  return camera;
}

using CamerasByView = std::map<std::string, MiddleburyCamera>;

// Those of a Middlebury list (`NAME_par.txt`) in the folder.
CamerasByView listed_cameras(const fs::path& folder, FolderGuess& guess) {
  CamerasByView cameras;
  for (const fs::path& file : files_in(folder)) {
    if (!file.filename().string().ends_with("_par.txt")) continue;
    const auto list = read_middlebury_par(file);
    if (!list) {
      guess.findings.push_back("left out " + list.error().message);
      continue;
    }
    guess.findings.push_back("cameras and poses of " + std::to_string(list->size()) +
                             " images from " + file.string());
    for (const MiddleburyCamera& camera : *list) cameras.emplace(view_of_name(camera.file), camera);
  }
  return cameras;
}

void take_listed_camera(const CamerasByView& cameras, ViewSpec& view) {
  const auto found = cameras.find(view.name);
  if (found == cameras.end() || !view.camera) return;
  view.camera->intrinsics = found->second.intrinsics;
  view.world_from_view = found->second.world_from_view;
  view.pose = PoseKind::kGuess;
}

// The matrix in a file of the view's own folder: `view_0/pose.txt` beside `view_0/depth.png`.
void take_pose_of_folder(const std::vector<NamedImage>& images, ViewSpec& view,
                         FolderGuess& guess) {
  const fs::path file = view.depth->file.parent_path() / "pose.txt";
  const bool is_own = std::ranges::any_of(images, &NamedImage::of_own_folder);
  if (!is_own || view.pose != PoseKind::kAbsent || !is_file(file)) return;
  const auto text = read_file(file);
  const auto pose = text ? parse_matrix_text(*text, file) : Result<RigidMotion>(text.error());
  if (!pose) {
    guess.findings.push_back("left out " + pose.error().message);
    return;
  }
  guess.findings.push_back("pose of " + view.name + " from " + file.string());
  view.world_from_view = *pose;
  view.pose = PoseKind::kGuess;
}

// Depth maps of whole numbers hold millimetres far more often than metres.
bool holds_whole_numbers(const fs::path& depth) {
  const std::string ending = lower_ending(depth);
  return ending == ".png" || ending == ".pgm";
}

// As far as their headers tell.
bool have_other_sizes(const fs::path& colour, const fs::path& depth) {
  const auto of_colour = image_size(colour), of_depth = image_size(depth);
  return of_colour && of_depth && *of_colour != *of_depth;
}

ViewSpec guessed_view(const std::string& name, const std::vector<NamedImage>& images,
                      const ReadProjectOptions& options, FolderGuess& guess) {
  ViewSpec view;
  view.name = name;
  for (const NamedImage& image : images) {
    switch (image.role) {
      case ImageRole::kDepth:
        view.depth = DepthSpec{image.file, 1.0, false};
        if (options.depth_scale) view.depth->scale = metres_per_step(*options.depth_scale);
        break;
      case ImageRole::kNormals:
        view.normals = NormalSpec{image.file, {}, {}, {}};
        break;
      case ImageRole::kMask:
        view.mask = ImageFile{image.file};
        break;
      case ImageRole::kConfidence:
        view.confidence = ImageFile{image.file};
        break;
      case ImageRole::kColour:
        view.colour = ImageFile{image.file};
        break;
    }
  }
  if (!view.depth) return view;
  if (view.colour && have_other_sizes(view.colour->file, view.depth->file)) {
    guess.findings.push_back("left out " + view.colour->file.string() +
                             ": its size is not that of " + view.depth->file.string());
    view.colour.reset();
  }
  view.camera = unknown_camera(view.depth->file);
  if (options.intrinsics) view.camera->intrinsics = *options.intrinsics;
  return view;
}

Result<FolderGuess> guess_from_images(const fs::path& folder, const ReadProjectOptions& options,
                                      const std::string& why_not_read) {
  std::map<std::string, std::vector<NamedImage>, NaturalOrder> by_view;
  for (NamedImage& image : named_images(folder)) by_view[image.view].push_back(std::move(image));
  FolderGuess guess;
  const CamerasByView cameras = listed_cameras(folder, guess);
  bool whole_numbers = false, without_camera = false;
  for (const auto& [name, images] : by_view) {
    ViewSpec view = guessed_view(name, images, options, guess);
    take_listed_camera(cameras, view);
    if (!view.depth) {
      for (const NamedImage& image : images)
        guess.findings.push_back("left out " + image.file.string() +
                                 ": no depth map has the rest of its name, '" + name + "'");
      continue;
    }
    take_pose_of_folder(images, view, guess);
    whole_numbers |= holds_whole_numbers(view.depth->file);
    without_camera |= !options.intrinsics && !cameras.contains(name);
    guess.project.views.push_back(std::move(view));
  }
  if (guess.project.views.empty())
    return bad_input(folder,
                     "no file in it can be a scan: names of depth maps have the word "
                     "'depth' or 'range', or they are PNG of 16 grey bits; grids and points end in "
                     ".ply, .pcd, .ptx, .e57, "
                     ".xyz or .pts. (" +
                         why_not_read + ")");
  take_poses_of_folder(folder, guess.project);
  std::ranges::move(std::exchange(guess.project.notes, {}), std::back_inserter(guess.findings));
  guess.project.unit = options.depth_scale ? "m" : whole_numbers ? "mm" : "units";
  if (without_camera)
    guess.missing.push_back("fx and fy of each camera [pixels]; cx and cy are set to the middle");
  if (whole_numbers && !options.depth_scale)
    guess.missing.push_back(
        "the scale of the depth maps: their value times the scale is in the unit; 1 was taken, as "
        "for whole millimetres");
  const bool posed = std::ranges::none_of(
      guess.project.views, [](const ViewSpec& view) { return view.pose == PoseKind::kAbsent; });
  if (!posed)
    guess.missing.push_back("where known: the pose of each view as \"world_from_view\" (4 x 4)");
  return guess;
}

// Depth maps of drafts have no focal length yet. Whether they can be read does not depend on it.
ViewSpec with_focal_length(ViewSpec view) {
  if (!view.camera) return view;
  for (double* length : {&view.camera->intrinsics.fx, &view.camera->intrinsics.fy})
    if (*length == 0.0) *length = 1.0;
  return view;
}

void read_views(FolderGuess& guess) {
  const std::vector<ViewSpec>& views = guess.project.views;
  std::vector<std::string> why(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (const auto loaded = load_view(with_focal_length(views[i])); !loaded)
        why[i] = "view " + views[i].name + ": " + loaded.error().message;
  });
  std::ranges::copy_if(why, std::back_inserter(guess.unreadable),
                       [](const std::string& text) { return !text.empty(); });
}

void put_comment(const std::string& text, std::string& out) {
  out += "// ";
  for (const char c : text) out += c == '\n' ? ' ' : c;
  out += '\n';
}

}  // namespace

Result<FolderGuess> guess_project(const fs::path& folder, const ReadProjectOptions& options) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) return bad_input(folder, "is no folder");
  auto project = read_project_spec(folder, options);
  if (!project) {
    const std::string& why_not_read = project.error().message;
    auto from_images = guess_from_images(folder, options, why_not_read);
    if (!from_images) return from_images;
    from_images->findings.insert(from_images->findings.begin(),
                                 "not read as it is: " + why_not_read);
    read_views(*from_images);
    return from_images;
  }
  FolderGuess guess;
  guess.project = std::move(*project);
  for (const std::string& note : guess.project.notes) guess.findings.push_back(note);
  read_views(guess);
  if (guess.unreadable.empty())
    guess.findings.push_back("all of it is read as it is; this file is for changes");
  return guess;
}

Result<ProjectSpec> read_depth_maps(const fs::path& folder, const ReadProjectOptions& options) {
  auto guess = guess_from_images(folder, options, "no list or calibration is beside the images");
  if (!guess) return guess.error();
  const auto whole_numbers = [](const ViewSpec& view) {
    return holds_whole_numbers(view.depth->file);
  };
  std::vector<ViewSpec>& views = guess->project.views;
  const ComparedDepths compared(guess->project);
  const bool assumes =
      !options.depth_scale && std::any_of(views.begin(), views.end(), whole_numbers);
  if (assumes) {
    auto assumed = assume_depth_scale(guess->project, kMillimetres, compared);
    if (!assumed) return assumed.error();
    for (ViewSpec& view : views)
      if (whole_numbers(view)) view.depth->scale = assumed->metres_per_value;
    guess->findings.push_back(std::move(assumed->note));
  }
  if (assumes) guess->project.unit = "m";
  guess->project.notes = std::move(guess->findings);
  take_pose_convention(guess->project, compared);
  take_ray_lengths(guess->project, compared);
  take_pose_scale(guess->project, compared);
  note_disagreement_at_poses(guess->project, compared);
  return std::move(guess->project);
}

std::string commented_scan_json(const FolderGuess& guess, const fs::path& folder) {
  std::string text;
  put_comment("Found " + std::to_string(guess.project.views.size()) + " views.", text);
  for (const std::string& line : guess.findings) put_comment(line, text);
  for (const std::string& line : guess.missing) put_comment("TO FILL IN: " + line, text);
  for (const std::string& line : guess.unreadable) put_comment("CANNOT BE READ: " + line, text);
  auto document = empty_project_json(guess.project.unit);
  for (const ViewSpec& view : guess.project.views)
    document["views"].push_back(view_json(view, folder));
  return text + document.dump(1) + "\n";
}

}  // namespace relief
