#pragma once

#include <filesystem>

#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"

namespace relief {

struct ColmapOptions {
  /// Where the centre of a depth map's first pixel lies, on both axes, in the coordinates of the
  /// scaled principal point [pixels of the depth map], in [0, 1]. COLMAP's images have it at 0.5,
  /// but its stereo step takes the pixel (u, v) at (u, v): its depth maps agree best, with each
  /// other and with the sparse points, at 0. For depth maps of programs that follow the images:
  /// 0.5.
  double pixel_centre = 0.0;
};

/// Whether `folder`, or `dense` or `dense/0` in it, is a workspace of COLMAP: a sparse model in
/// `sparse` or `sparse/0`, and a folder `stereo`.
bool is_colmap_workspace(const std::filesystem::path& folder);

/// A dense workspace of COLMAP as a project: one view for each image with a depth map, the
/// geometric one or else the photometric. Its normals are those of the same kind, its colours the
/// image itself where it has the size of the depth map. Intrinsics are scaled, axis by axis, to the
/// size of the depth map. The unit is `units`: a workspace has no scale. The notes name images
/// without a depth map or with an empty one, and say how far depths are from the sparse points.
/// kBadInput names file and place.
Result<ProjectSpec> read_colmap_workspace(const std::filesystem::path& folder,
                                          const ColmapOptions& options = {});

}  // namespace relief
