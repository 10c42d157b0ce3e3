#pragma once

#include <filesystem>
#include <optional>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

/// Reads the `metadata.json` of a recording by Record3D (LiDAR and TrueDepth cameras of
/// telephones): `K` column by column for images of `w` by `h`, depth maps of `dw` by `dh`, `poses`
/// as qx qy qz qw tx ty tz with y up and z back. Nothing where the folder has none with a `K`.
/// kBadInput names what is wrong in it.
Result<std::optional<Recording>> read_record3d_metadata(const std::filesystem::path& folder);

}  // namespace relief
