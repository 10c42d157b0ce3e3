#pragma once

#include <vector>

#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

/// The conventions in which depth maps are compared, the one as given first. Other units and
/// rotations come with the axes of OpenCV and OpenGL alone: that bounds the time.
std::vector<PoseConvention> possible_conventions();

/// Takes the poses of a project in another convention where its depth maps agree far better so
/// (kFarBetter): from the world to the camera, with other axes of the camera (any of x, y and z to
/// the right, down, forward, or against), in a left-handed world, with quaternions of another
/// order or inverse rotations, in millimetres or centimetres beside depths in metres or the other
/// way round. A note says so. Without poses nothing changes.
/// `stored_axes`: those that the format states (PoseConvention::axes), for the note.
void take_pose_convention(ProjectSpec& project, const ComparedDepths& compared,
                          const Eigen::Matrix3d& stored_axes = Eigen::Matrix3d::Identity());

/// Adds a note where the depth maps disagree at their poses by more than any depth camera errs.
void note_disagreement_at_poses(ProjectSpec& project, const ComparedDepths& compared);

}  // namespace relief
