#include <algorithm>
#include <utility>

#include "apps/reports/comparison/run_comparison.h"
#include "relief/io/project_io.h"

namespace relief {

namespace {

const NamedPose* pose_of(const std::vector<NamedPose>& poses, const std::string& name) {
  const auto found = std::find_if(poses.begin(), poses.end(),
                                  [&](const NamedPose& pose) { return pose.name == name; });
  return found == poses.end() ? nullptr : &*found;
}

// The views of a project that have samples and stand in both lists of poses, and the same views
// without samples at the poses of the other run.
struct CommonViews {
  ScanProject reference, other;
};

CommonViews common_views(ScanProject project, const std::vector<NamedPose>& reference_poses,
                         const std::vector<NamedPose>& other_poses) {
  CommonViews common;
  for (RangeView& view : project.views) {
    const NamedPose* here = pose_of(reference_poses, view.name);
    const NamedPose* there = pose_of(other_poses, view.name);
    if (!here || !there || view.sample_count() == 0) continue;
    RangeView posed;
    posed.name = view.name;
    posed.world_from_view = there->world_from_view;
    posed.pose = view.pose = PoseKind::kGuess;
    view.world_from_view = here->world_from_view;
    common.other.views.push_back(std::move(posed));
    common.reference.views.push_back(std::move(view));
  }
  return common;
}

}  // namespace

Result<ComparedPoses> compare_poses(const RunFolder& a, const RunFolder& b, bool fit,
                                    const Context& context) {
  auto project = read_project(a.folder / "scan.json", {}, context);
  const bool samples_of_a = project.ok();
  if (!project) project = read_project(b.folder / "scan.json", {}, context);
  if (!project && project.error().kind == ErrorKind::kInterrupted) return project.error();
  if (!project)
    return Error{ErrorKind::kUnsolvable,
                 "neither folder has views with samples: " + project.error().message};
  const auto poses_of_a = a.poses(), poses_of_b = b.poses();
  const CommonViews views = samples_of_a
                                ? common_views(std::move(*project), poses_of_a, poses_of_b)
                                : common_views(std::move(*project), poses_of_b, poses_of_a);
  if (views.reference.views.empty())
    return Error{ErrorKind::kUnsolvable, "no view is placed in both runs"};
  // A view that only one run placed wrongly must not pull at the others.
  auto errors = evaluation::evaluate_poses(views.other, views.reference,
                                           {.fit_common_motion = fit, .robust = true});
  if (!errors) return errors.error();
  const RigidMotion fitted = errors->truth_from_result;
  return ComparedPoses{std::move(*errors), samples_of_a ? fitted : fitted.inverse()};
}

}  // namespace relief
