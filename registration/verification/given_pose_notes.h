#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A view that came with a pose and is aligned. Poses are world from view; the world may have moved
/// from one to the other.
struct GivenAndFound {
  std::string name;
  RigidMotion given = RigidMotion::Identity(), found = RigidMotion::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of its samples, view frame.
  bool refined = false;  ///< From the given pose, not found by shape; the world is the same.
  /// All its rays start at the origin of its frame, where the sensor stood.
  bool from_origin = false;
  std::optional<Eigen::Vector2d> focal_lengths = {};  ///< fx and fy of a pinhole [pixels].
};

/// The same of a view, with the `centre` of its samples.
GivenAndFound given_and_found(const RangeView& view, const Eigen::Vector3d& centre,
                              const RigidMotion& given, const RigidMotion& found, bool refined);

/// How many times as far apart as given the sensors of views `from_origin` were found: 1.02 where
/// ranges are 2 % too long for the poses, or the poses in a smaller unit. Nothing for fewer than
/// four of them, and where it is no more than a thousandth, or not four times what single distances
/// scatter by.
std::optional<double> common_scale(const std::vector<GivenAndFound>& all);

/// 0 or 1 where the poses found are the given ones in a mirror that exchanges the sides of x or of
/// y in the frame of each view: four times nearer than without. Nothing for fewer than four views.
std::optional<int> mirrored_axis(const std::vector<GivenAndFound>& views);

/// For the user: how far refining moved the given poses, and what common_scale(),
/// mirrored_axis() and common_shift() tell. Of scale and shift the one that fits better.
std::vector<std::string> notes_on_given_poses(const std::vector<GivenAndFound>& views);

}  // namespace relief::registration
