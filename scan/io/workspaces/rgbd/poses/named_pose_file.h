#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

struct NamedPoseFile {
  std::filesystem::path path;
  PosesOfFrames world_from_view;
  std::vector<std::string> notes;  ///< What else was assumed.
};

/// The poses of frames in a .json, .csv, .txt or .npy of a folder (named_poses.h): by the names or
/// numbers of the frames, or else, in a file that is named as poses, by the order, where there is
/// one for each frame. Numbers may count from another one than the frames, with a note. Files named
/// as poses go first. Nothing where there are none; kBadInput for two such files that differ, and
/// for a file named as poses that has an error. Other files with errors hold something else.
Result<std::optional<NamedPoseFile>> find_named_poses(const std::filesystem::path& folder,
                                                      const std::vector<RgbdFrame>& frames);

/// Whether a file that somebody gives holds such poses, perhaps with an error, or is named as
/// poses.
bool holds_named_poses(const std::filesystem::path& file);

/// The same poses of one file, whatever its name. kBadInput where it holds none, or none of these
/// frames.
Result<NamedPoseFile> read_named_poses(const std::filesystem::path& file,
                                       const std::vector<RgbdFrame>& frames);

/// What to say of a file without such poses, behind its name.
inline constexpr const char* kNoFormOfPoses =
    "has no form of poses that is known; write 'tx ty tz qx qy qz qw' or the 16 numbers of "
    "world_from_view a line, in the order of the views";

/// Says that so many of the poses of a file are lost; nothing for none.
std::optional<std::string> note_on_lost_poses(std::ptrdiff_t lost, std::size_t poses);

/// The texts and arrays of a folder whose names speak of poses: what to name where none could be
/// read.
std::vector<std::filesystem::path> files_named_as_poses(const std::filesystem::path& folder);

}  // namespace relief
