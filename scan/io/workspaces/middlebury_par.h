#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// One image of a Middlebury multi-view set.
struct MiddleburyCamera {
  std::string file;              ///< As it stands in the list.
  PinholeIntrinsics intrinsics;  ///< Integer coordinates are pixel centres.
  /// Frame x right, y down, z forward. The inverse of what the file holds.
  RigidMotion world_from_view = RigidMotion::Identity();
};

/// Parses a `_par.txt`: the number of images, and for each a line
/// `name k11 ... k33 r11 ... r33 t1 t2 t3`, where K [R t] projects the world. kBadInput names the
/// line, also for skew and for a rotation that is none.
Result<std::vector<MiddleburyCamera>> parse_middlebury_par(std::string_view text,
                                                           const std::filesystem::path& path);

/// The same for a file.
Result<std::vector<MiddleburyCamera>> read_middlebury_par(const std::filesystem::path& path);

}  // namespace relief
