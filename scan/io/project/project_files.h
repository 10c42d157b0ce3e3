#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// A file name made of a view's name: letters, digits, `-`, `_` and `.` only, unlike all in
/// `taken`, to which it is added.
std::string view_file_stem(const std::string& view, std::set<std::string>& taken);

/// The files that a project is read from: the one that describes it, images and grids of its views.
std::vector<std::filesystem::path> files_read_for(const ProjectSpec& project);

/// The files that write_project() may write into `folder` for views of the same names. Which of
/// them are written depends on what the views have.
std::vector<std::filesystem::path> files_written_for(const ProjectSpec& project,
                                                     const std::filesystem::path& folder);

/// Whether write_project() writes a view as a grid file whatever its options: the frame of a sensor
/// that is not a pinhole need not be x right, y down, z forward, so its points and normals go into
/// a file in the frame they are in.
bool needs_grid_file(const RangeView& view);

}  // namespace relief
