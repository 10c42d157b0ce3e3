#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Parses the text of a MeshLab project (.mlp): each `MLMesh` is a view, whose grid is the file
/// `filename`, relative to the folder of `path`. `MLMatrix44` is world_from_view, sixteen numbers
/// row by row, on one line or on four; words behind them that are no numbers are not looked at. A
/// mesh without matrix has no pose. Raster layers are named in a note. The unit is `units`: the
/// format has none. kBadInput names the line.
Result<ProjectSpec> parse_meshlab_mlp(const std::string& text, const std::filesystem::path& path);

}  // namespace relief
