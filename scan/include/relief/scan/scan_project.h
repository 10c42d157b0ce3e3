#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// Several range views of one object, in one length unit.
struct ScanProject {
  std::string unit = "mm";  ///< Of every length, e.g. `mm` or `m`; nothing depends on it.
  std::vector<RangeView> views;
  /// What the reader had to find out by itself (camera models, axes of normals), one line each, for
  /// the user's log.
  std::vector<std::string> notes;
  /// Names of views of points without a grid that are taken as seen from the origin of their frame,
  /// though neither file nor user says so.
  std::vector<std::string> seen_from_origin;
};

/// The view called `name`; null when there is none.
inline const RangeView* find_view(const ScanProject& project, std::string_view name) {
  for (const RangeView& view : project.views)
    if (view.name == name) return &view;
  return nullptr;
}

/// The pose of the view of this name.
struct NamedPose {
  std::string name;
  RigidMotion world_from_view = RigidMotion::Identity();
};

}  // namespace relief
