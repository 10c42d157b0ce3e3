// How long relief takes to read files of scans, against PCL on the same file in the same process:
//   relief_read_speed FILE ...
// Each file is read five times by both in turns; the least time of each counts.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>

#include <pcl/console/print.h>
#include <pcl/io/obj_io.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/project/scan_file.h"

namespace {

double seconds_of(const std::function<bool()>& read) {
  const auto start = std::chrono::steady_clock::now();
  if (!read()) return std::numeric_limits<double>::infinity();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Into the typed cloud that PCL's users work with.
bool read_by_pcl(const std::filesystem::path& path) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  const std::string ending = path.extension().string();
  if (ending == ".pcd") return pcl::io::loadPCDFile(path.string(), cloud) == 0;
  if (ending == ".ply") return pcl::io::loadPLYFile(path.string(), cloud) == 0;
  return ending == ".obj" && pcl::io::loadOBJFile(path.string(), cloud) == 0;
}

// Points alone: that they are put on a grid is no part of reading.
bool read_by_relief(const std::filesystem::path& path) {
  return relief::kind_of_scan_file(path) == relief::ScanFileKind::kPoints
             ? relief::read_point_cloud(path).ok()
             : relief::read_scan_file(path).ok();
}

}  // namespace

int main(int argc, char** argv) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  std::printf("%-40s %10s %10s %8s\n", "file", "relief s", "PCL s", "ratio");
  for (int i = 1; i < argc; ++i) {
    const std::filesystem::path path = argv[i];
    double relief = std::numeric_limits<double>::infinity(), pcl = relief;
    for (int turn = 0; turn < 5; ++turn) {
      relief = std::min(relief, seconds_of([&] { return read_by_relief(path); }));
      pcl = std::min(pcl, seconds_of([&] { return read_by_pcl(path); }));
    }
    std::printf("%-40s %10.4f %10.4f %8.2f\n", path.filename().c_str(), relief, pcl, relief / pcl);
  }
}
