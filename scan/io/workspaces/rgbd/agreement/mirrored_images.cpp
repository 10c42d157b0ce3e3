#include "scan/io/workspaces/rgbd/agreement/mirrored_images.h"

#include <cstdio>

#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

namespace {

std::string note_text(const PinholeIntrinsics& k, double as_given, double mirrored) {
  char text[400];
  std::snprintf(text, sizeof text,
                "with fy = %g the depth maps disagree at their poses by %.2g %% of the depth, with "
                "fy = %g by %.2g %%: the images seem mirrored, or y of the cameras upwards; give "
                "--intrinsics %g %g %g %g",
                k.fy, 100.0 * as_given, -k.fy, 100.0 * mirrored, k.fx, -k.fy, k.cx, k.cy);
  return text;
}

}  // namespace

std::optional<std::string> note_on_mirrored_images(const ProjectSpec& project) {
  if (project.views.empty() || !project.views.front().camera) return std::nullopt;
  const PinholeIntrinsics& intrinsics = project.views.front().camera->intrinsics;
  PinholeIntrinsics mirrored = intrinsics;
  mirrored.fy = -mirrored.fy;
  const auto found = disagreements_at_poses(project, {{intrinsics}, {mirrored}});
  if (!found[0] || !found[1] || !(*found[0] > kFarBetter * *found[1])) return std::nullopt;
  return note_text(intrinsics, *found[0], *found[1]);
}

}  // namespace relief
