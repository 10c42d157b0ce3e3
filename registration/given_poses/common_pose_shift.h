#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "registration/given_poses/given_pose_notes.h"

namespace relief::registration {

/// By how much the samples of all views were found off their given poses, alike in the frame of
/// each view [unit]: a shift that leaves a quarter of the distances between both. Only of `refined`
/// views. Nothing for fewer than six, and where they do not differ so. Along what turns with no
/// view, as the axis of a turntable, any shift fits: the one with z = 0 is told where it explains
/// the poses and a shift along z does not.
std::optional<Eigen::Vector3d> common_shift(const std::vector<GivenAndFound>& all);

/// Whether common_shift() leaves smaller distances than a factor between all places of sensors.
bool shift_explains_more_than_scale(const std::vector<GivenAndFound>& all);

}  // namespace relief::registration
