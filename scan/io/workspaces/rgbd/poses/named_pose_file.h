#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

struct NamedPoseFile {
  std::filesystem::path path;
  std::vector<std::optional<RigidMotion>> world_from_view;  ///< Of each frame.
};

/// The first .json, .csv, .txt or .npy of a folder that has poses (named_poses.h) of its frames, by
/// their names or numbers; or as many poses as there are frames, then in their order. Nothing where
/// there is none; kBadInput names the place of a pose that is none.
Result<std::optional<NamedPoseFile>> find_named_poses(const std::filesystem::path& folder,
                                                      const std::vector<RgbdFrame>& frames);

/// The files of a folder whose names speak of poses: what to name where none could be read.
std::vector<std::filesystem::path> files_named_as_poses(const std::filesystem::path& folder);

}  // namespace relief
