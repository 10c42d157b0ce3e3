#pragma once

#include <string>

#include "relief/scan/rigid_motion.h"

namespace relief {

/// The pose of the view of this name.
struct NamedPose {
  std::string name;
  RigidMotion world_from_view = RigidMotion::Identity();
};

}  // namespace relief
