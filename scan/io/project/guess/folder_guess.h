#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "relief/io/project_io.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// What the files of a folder seem to be, for the user to correct.
struct FolderGuess {
  ProjectSpec project;
  std::vector<std::string> findings;    ///< What was taken for what, and why. For the user.
  std::vector<std::string> missing;     ///< What the project still needs before it can be read.
  std::vector<std::string> unreadable;  ///< Why views cannot be read, whatever is filled in.
};

/// Looks at a folder, and reads all views once to see that they can be read. What
/// read_project_spec() understands is taken as it is. Else depth maps, normal maps, masks,
/// confidences and colours are told by words in their names (`depth`, `normal`, `mask`, ...) and
/// belong to one view when the rest of their names is equal, or when they lie in a folder of the
/// view, where `pose.txt` is its pose. A Middlebury list
/// (`NAME_par.txt`) gives cameras and poses of the images it names. Without a calibration every
/// camera has the focal length 0, which no reader accepts: it must be filled in.
/// kBadInput when nothing in the folder can be a scan.
Result<FolderGuess> guess_project(const std::filesystem::path& folder,
                                  const ReadProjectOptions& options = {});

/// Reads a folder of depth maps with the intrinsics of `options`: what belongs together is told as
/// by guess_project(). kBadInput when no image can be a depth map, or when the maps hold whole
/// numbers and `options` no scale of them.
Result<ProjectSpec> read_depth_maps(const std::filesystem::path& folder,
                                    const ReadProjectOptions& options);

/// The text of a scan.json, for `folder`, with the findings and what is missing as comments.
std::string commented_scan_json(const FolderGuess& guess, const std::filesystem::path& folder);

}  // namespace relief
