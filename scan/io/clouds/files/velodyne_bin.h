#pragma once

#include <filesystem>

#include "relief/scan/result.h"
#include "scan/io/clouds/files/point_cloud_file.h"

namespace relief {

/// Whether a file holds points of a lidar as bare floats, as the sweeps of KITTI (x y z intensity)
/// and of nuScenes (and the number of the ring behind). Nothing in them says so: the size of the
/// file, and the numbers of points all over it, tell.
bool is_velodyne_bin(const std::filesystem::path& path);

/// Reads such a file: little-endian floats of 32 bits, in metres, seen from the origin. Intensities
/// become grey. kBadInput where it is none.
Result<PointCloudFile> read_velodyne_bin(const std::filesystem::path& path);

}  // namespace relief
