#pragma once

#include <optional>
#include <string>

#include "scan/io/project/view_spec.h"

namespace relief {

/// Whether the depth maps of a project agree with their poses far better when fy has the other
/// sign: so do images that are mirrored, or a trajectory whose cameras have y upwards. A note for
/// the user that names the intrinsics to give; nothing where the maps agree as they are, have no
/// poses, or cannot be read.
std::optional<std::string> note_on_mirrored_images(const ProjectSpec& project);

}  // namespace relief
