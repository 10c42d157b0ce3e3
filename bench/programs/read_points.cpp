// The points that relief reads from files of scans, before they are put on a grid, for comparison
// with other readers:
//   relief_read_points FILE OUTPUT
// writes the points of all scans of FILE as text: the number of the scan, x y z in the frame and
// unit of the file, and, where the scan has colours, red green blue.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/project/scan_file.h"

namespace {

using namespace relief;

struct Points {
  std::vector<Eigen::Vector3d> points;
  std::vector<Colour> colours;
};

Result<Points> points_of_e57(const std::filesystem::path& path, int scan) {
  auto cloud = read_e57_cloud(path, scan);
  if (!cloud) return cloud.error();
  return Points{std::move(cloud->points), std::move(cloud->colours)};
}

Result<Points> points_of_cloud(const std::filesystem::path& path) {
  auto cloud = read_point_cloud(path);
  if (!cloud) return cloud.error();
  return Points{std::move(cloud->points), std::move(cloud->colours)};
}

// Before a scan of one row is put on a grid.
Result<Points> points_of_ptx(const std::filesystem::path& path, int scan) {
  auto grid = read_ptx_scan(path, scan);
  if (!grid) grid = read_ptx_scan(path, scan, PtxMatrix::kApply);
  if (!grid) return grid.error();
  PointCloudFile cloud = cloud_of_grid(*grid);
  return Points{std::move(cloud.points), std::move(cloud.colours)};
}

Result<Points> points_of_grid(const std::filesystem::path& path, int scan) {
  const auto grid = read_scan_file(path, {.scan = scan});
  if (!grid) return grid.error();
  PointCloudFile cloud = cloud_of_grid(*grid);
  return Points{std::move(cloud.points), std::move(cloud.colours)};
}

Result<Points> read_points(const std::filesystem::path& path, int scan) {
  if (lower_ending(path) == ".e57") return points_of_e57(path, scan);
  if (lower_ending(path) == ".ptx") return points_of_ptx(path, scan);
  if (kind_of_scan_file(path) == ScanFileKind::kPoints) return points_of_cloud(path);
  return points_of_grid(path, scan);
}

void write_points(std::FILE* output, int scan, const Points& read) {
  for (std::size_t i = 0; i < read.points.size(); ++i) {
    const Eigen::Vector3d& p = read.points[i];
    std::fprintf(output, "%d %.17g %.17g %.17g", scan, p.x(), p.y(), p.z());
    if (!read.colours.empty())
      for (const int level : read.colours[i]) std::fprintf(output, " %d", level);
    std::fputc('\n', output);
  }
}

int fail(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: relief_read_points FILE OUTPUT\n", stderr);
    return 2;
  }
  const auto scans = list_scans(argv[1]);
  if (!scans) return fail(scans.error());
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> output(std::fopen(argv[2], "w"),
                                                               std::fclose);
  if (!output) return fail({ErrorKind::kCannotWrite, std::string(argv[2]) + ": cannot be written"});
  for (int scan = 0; scan < static_cast<int>(scans->size()); ++scan) {
    const auto read = read_points(argv[1], scan);
    if (!read) return fail(read.error());
    write_points(output.get(), scan, *read);
  }
  return std::ferror(output.get()) ? 1 : 0;
}
