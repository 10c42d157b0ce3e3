#pragma once

#include <string>
#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What a program may mean by the poses that it writes, other than world_from_view.
struct PoseConvention {
  double unit = 1.0;         ///< Of the translations [unit of the views].
  bool inverse = false;      ///< view_from_world.
  bool opengl_axes = false;  ///< Of a view whose axes y and z are turned round.

  bool as_given() const { return unit == 1.0 && !inverse && !opengl_axes; }
  /// world_from_view of a pose in this convention.
  RigidMotion world_from_view(RigidMotion pose) const;
  /// In words, as `view_from_world with the axes of OpenGL`.
  std::string describe() const;
};

/// The convention in which the given poses bring the views together; as given, unless another one
/// is clearly better. Views agree by the part of the samples of each that lies near the surface of
/// the view that it fits best (rough_agreement()), so poses may be guesses.
/// `given`: of the views whose poses count.
PoseConvention find_pose_convention(const std::vector<ViewSurface>& surfaces,
                                    const std::vector<RigidMotion>& poses,
                                    const std::vector<bool>& given);

}  // namespace relief::registration
