#include "scan/io/workspaces/rgbd/rgbd_folder.h"

#include <algorithm>
#include <set>
#include <string>

#include "scan/io/files/folder_files.h"
#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"
#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"
#include "scan/io/workspaces/rgbd/agreement/pose_scale.h"
#include "scan/io/workspaces/rgbd/agreement/ray_lengths.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/poses/frame_poses.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// What a recording tells of the frames. Poses in files of their own go first.
void take_recording(const Recording& recording, RgbdFrames& found) {
  const bool wants_poses = !found.has_poses;
  for (RgbdFrame& frame : found.frames) {
    frame.intrinsics = recording.calibration.intrinsics;
    frame.size = recording.calibration.size;
    if (recording.masks) {
      const fs::path mask = *recording.masks / frame.depth.filename();
      if (is_file(mask)) frame.mask = mask;
    }
    const auto number = frame_number(frame.name);
    const auto told = number ? recording.frames.find(*number) : recording.frames.end();
    if (told == recording.frames.end()) continue;
    const RecordedFrame& recorded = told->second;
    if (recorded.intrinsics) frame.intrinsics = recorded.intrinsics;
    frame.depth_step = recorded.depth_step;
    if (!wants_poses || !recorded.world_from_view) continue;
    frame.pose = recorded.world_from_view;
    found.has_poses = true;
  }
}

// What holds for all frames of a folder.
struct RgbdSetting {
  std::optional<PinholeIntrinsics> intrinsics;
  std::optional<ImageSize> size;
  std::optional<double> depth_step;  // [m]; nothing where nobody states it.
};

Result<RgbdSetting> find_setting(const fs::path& folder, const RgbdFrames& found,
                                 const std::optional<Recording>& recording,
                                 const RgbdOptions& options, std::vector<std::string>& notes) {
  if (options.intrinsics && !can_be_intrinsics(*options.intrinsics))
    return bad_input(folder, "the focal lengths FX and FY of --intrinsics must not be 0");
  RgbdSetting setting;
  Calibration calibration;
  if (!options.intrinsics || !options.depth_scale) {
    auto file = find_calibration(folder);
    if (file && !*file && !recording) file = find_calibration_beside(folder);
    if (!file && !options.intrinsics) return file.error();
    if (!file) {
      notes.push_back(file.error().message + " (not used: --intrinsics are given)");
    } else if (*file) {
      calibration = std::move(**file);
    } else if (recording) {  // Frames have its intrinsics already.
      calibration.depth_scale = recording->calibration.depth_scale;
      calibration.notes = recording->calibration.notes;
    }
    notes.insert(notes.end(), calibration.notes.begin(), calibration.notes.end());
  }
  setting.intrinsics = options.intrinsics ? options.intrinsics : calibration.intrinsics;
  if (!options.intrinsics) setting.size = calibration.size;
  const auto scale = options.depth_scale       ? options.depth_scale
                     : calibration.depth_scale ? calibration.depth_scale
                                               : found.depth_scale;
  if (scale && !(*scale > 0.0))
    return bad_input(folder,
                     "the scale of the depth maps must be more than 0: values to the metre, as "
                     "1000 when they are millimetres");
  if (scale) setting.depth_step = metres_per_step(*scale);
  return setting;
}

// Files that are named like calibrations, and are none.
std::string words_on_files_without(const fs::path& folder) {
  std::string names;
  for (const fs::path& file : files_in(folder))
    if (has_calibration_name(file)) names += (names.empty() ? "" : ", ") + file.filename().string();
  return names.empty() ? "" : "; none can be read in " + names;
}

Result<CameraSpec> camera_of_frame(const fs::path& folder, const RgbdFrame& frame,
                                   const RgbdSetting& setting,
                                   const std::optional<TrajectoryPose>& pose) {
  CameraSpec camera;
  auto intrinsics = setting.intrinsics;
  auto size = setting.size;
  if (!intrinsics && frame.intrinsics) {
    intrinsics = frame.intrinsics;
    size = frame.size;
  } else if (!intrinsics && pose && pose->intrinsics) {
    intrinsics = pose->intrinsics;
    size = pose->size;
  }
  if (!intrinsics)
    return bad_input(folder,
                     "depth maps without intrinsics: give --intrinsics FX FY CX CY, or put a "
                     "calibration file (camera.txt with 'fx fy cx cy', or a .json or .yaml "
                     "with fx, fy, cx and cy) beside them" +
                         words_on_files_without(folder));
  camera.intrinsics = *intrinsics;
  if (size) {
    camera.width = size->width;
    camera.height = size->height;
  }
  return camera;
}

// A frame's colours are usable where each depth pixel has one.
bool colours_fit(const RgbdFrame& frame) {
  const auto depth = image_size(frame.depth), colour = image_size(*frame.colour);
  return depth && colour && *depth == *colour;
}

Result<void> add_frame(const fs::path& folder, const RgbdFrame& frame,
                       const std::optional<TrajectoryPose>& pose, const RgbdSetting& setting,
                       std::set<std::string>& names, ProjectSpec& project, std::size_t& misfits) {
  const auto camera = camera_of_frame(folder, frame, setting, pose);
  if (!camera) return camera.error();
  ViewSpec view;
  view.name =
      free_view_name(frame.name, [&](const std::string& name) { return names.contains(name); });
  names.insert(view.name);
  view.depth =
      DepthSpec{frame.depth, setting.depth_step.value_or(frame.depth_step.value_or(1.0)), false};
  view.camera = *camera;
  if (frame.mask) view.mask = ImageFile{*frame.mask};
  if (frame.colour && colours_fit(frame))
    view.colour = ImageFile{*frame.colour};
  else if (frame.colour)
    ++misfits;
  if (pose) {
    view.world_from_view = pose->world_from_view;
    view.pose = PoseKind::kGuess;
  }
  project.views.push_back(std::move(view));
  return {};
}

Result<void> take_assumed_scale(double usual, const ComparedDepths& compared,
                                ProjectSpec& project) {
  auto assumed = assume_depth_scale(project, usual, compared);
  if (!assumed) return assumed.error();
  for (ViewSpec& view : project.views) view.depth->scale = assumed->metres_per_value;
  project.notes.push_back(std::move(assumed->note));
  return {};
}

void add_counts(const FramePoses& poses, std::size_t misfits, std::vector<std::string>& notes) {
  const auto without = std::count(poses.begin(), poses.end(), std::nullopt);
  const auto all = std::to_string(poses.size());
  if (without > 0)
    notes.push_back(std::to_string(without) + " of " + all + " depth maps have no pose");
  if (misfits > 0)
    notes.push_back(std::to_string(misfits) + " of " + all +
                    " colour images are not used: their size is not that of the depth map");
}

}  // namespace

bool is_rgbd_folder(const fs::path& folder) { return rgbd_layout(folder) != RgbdLayout::kNone; }

Result<ProjectSpec> read_rgbd_folder(const fs::path& folder, const RgbdOptions& options) {
  auto found = list_rgbd_frames(folder);
  if (!found) return found.error();
  ProjectSpec project;
  project.unit = "m";
  project.notes = std::move(found->notes);
  const auto recording = find_recording(folder);
  if (!recording) return recording.error();
  if (*recording) take_recording(**recording, *found);
  const auto setting = find_setting(folder, *found, *recording, options, project.notes);
  if (!setting) return setting.error();
  const auto poses = find_frame_poses(folder, *found, project.notes);
  if (!poses) return poses.error();
  std::set<std::string> names;
  std::size_t misfits = 0;
  for (std::size_t i = 0; i < poses->size(); ++i)
    if (auto added =
            add_frame(folder, found->frames[i], (*poses)[i], *setting, names, project, misfits);
        !added)
      return added.error();
  add_counts(*poses, misfits, project.notes);
  const ComparedDepths compared(project);
  const bool steps_known = std::ranges::all_of(
      found->frames, [](const RgbdFrame& frame) { return frame.depth_step.has_value(); });
  if (!setting->depth_step && !steps_known)
    if (auto taken = take_assumed_scale(found->usual_depth_scale, compared, project); !taken)
      return taken.error();
  take_pose_convention(project, compared);
  take_ray_lengths(project, compared);
  take_pose_scale(project, compared);
  note_disagreement_at_poses(project, compared);
  return project;
}

}  // namespace relief
