#pragma once

#include <optional>
#include <vector>

#include "registration/given_poses/given_pose_notes.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What all given poses have wrong alike. They may be those of a body that the sensor is fixed to,
/// as the flange of a robot or a colour camera, and their translations may be in another scale.
struct HandEye {
  double scale = 1.0;  ///< Of the translations of the given poses.
  RigidMotion body_from_view = RigidMotion::Identity();
};

/// Solves given_ij(scale) body_from_view = body_from_view found_ij for the motions between views
/// (Tsai and Lenz 1989; the rotation by Park and Martin 1994), robustly. Of the scale alone, the
/// sensor's place alone, and both, the simplest that leaves no more than twice the least. Nothing
/// for fewer than three views, and where the motions do not come four times nearer than as given.
std::optional<HandEye> calibrate_hand_eye(const std::vector<GivenAndFound>& views);

/// Of the motions between views, how far the given ones put samples from where the found ones do
/// [unit], in the median. Two views at least.
double median_error(const HandEye& hand_eye, const std::vector<GivenAndFound>& views);

}  // namespace relief::registration
