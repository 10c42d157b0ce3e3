#pragma once

#include <filesystem>

#include "relief/io/project_io.h"
#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Sets in the views of a project what `options` say of files of scans: the viewpoint, where a view
/// has none of its own; that poses of files are not taken; the intrinsics of grids without a
/// camera. An option that no view of `path` needs adds a note. kBadInput where the file of
/// intrinsics cannot be read.
Result<void> apply_options_of_input(const ReadProjectOptions& options,
                                    const std::filesystem::path& path, ProjectSpec& project);

}  // namespace relief
