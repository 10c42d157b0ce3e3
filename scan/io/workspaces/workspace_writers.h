#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// The text of a MeshLab project of `views`, whose mesh or grid files are `files` (one for each, as
/// seen from the project's folder). Numbers have 17 digits: poses are read back as they were. Views
/// without a pose are written at the identity.
std::string meshlab_mlp_text(const std::vector<RangeView>& views,
                             const std::vector<std::string>& files);

/// Writes `NAME.xf` (four rows of world_from_view, 17 digits) for each view into `folder`, which is
/// made. kBadInput for names that are no file names; kCannotWrite.
Result<void> write_xf_folder(const std::vector<RangeView>& views,
                             const std::filesystem::path& folder);

/// Writes the text model of COLMAP, `cameras.txt`, `images.txt` and an empty `points3D.txt`, into
/// `folder`, which is made: a PINHOLE camera and an image `NAME.png` for each view. The principal
/// point is moved by the half pixel that COLMAP counts more. Numbers have 17 digits. kBadInput for
/// views of other cameras, with the remedy; kCannotWrite.
Result<void> write_colmap_text(const std::vector<RangeView>& views,
                               const std::filesystem::path& folder);

}  // namespace relief
