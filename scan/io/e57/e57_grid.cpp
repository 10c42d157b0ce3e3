#include <limits>

#include "scan/io/e57/e57_file.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

// A scan of a small object may leave most of its grid empty, but a file of a few points must not
// take the memory of a large grid.
constexpr std::size_t kFreeCells = std::size_t{1} << 20;  // any scan may have so many
constexpr std::size_t kCellsPerPoint = 256;               // and so many more for each point

GridFile empty_grid_for(const E57Cloud& cloud) {
  GridFile grid;
  grid.points =
      Grid<Eigen::Vector3d>(cloud.width, cloud.height, Eigen::Vector3d::Constant(kNoSample));
  if (!cloud.normals.empty())
    grid.normals = Grid<Eigen::Vector3f>(cloud.width, cloud.height,
                                         Eigen::Vector3f::Constant(static_cast<float>(kNoSample)));
  if (!cloud.colours.empty()) grid.colours = Grid<Colour>(cloud.width, cloud.height, Colour{});
  return grid;
}

bool too_many_cells(const E57Cloud& cloud) {
  const std::size_t cells =
      static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height);
  return cells > kFreeCells && (cells - kFreeCells) / kCellsPerPoint > cloud.points.size();
}

// How many points lost their place to a nearer one.
std::size_t fill_grid(const E57Cloud& cloud, GridFile& grid) {
  std::size_t lost = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const std::size_t cell = grid.points.index(cloud.columns[i], cloud.rows[i]);
    const bool taken = grid.points[cell].allFinite();
    if (taken) ++lost;
    if (taken && grid.points[cell].squaredNorm() <= cloud.points[i].squaredNorm()) continue;
    grid.points[cell] = cloud.points[i];
    if (!cloud.normals.empty()) grid.normals[cell] = cloud.normals[i];
    if (!cloud.colours.empty()) grid.colours[cell] = cloud.colours[i];
  }
  return lost;
}

}  // namespace

bool is_thinned_out(const E57Cloud& cloud) {
  // Of a surface seen on its grid nearly every point has a neighbour; at its edges still one half.
  // Of points of which a part p was kept at random 1 - (1 - p)^2 have one, 0.25 where p is 13 %.
  constexpr double kLeastWithNeighbour = 0.25;  // Fraction of the points.
  if (!cloud.structured || too_many_cells(cloud)) return cloud.structured;
  Grid<unsigned char> taken(cloud.width, cloud.height);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) taken(cloud.columns[i], cloud.rows[i]) = 1;
  std::size_t with_neighbour = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const int u = cloud.columns[i], v = cloud.rows[i];
    with_neighbour += (u + 1 < cloud.width && taken(u + 1, v)) || (u > 0 && taken(u - 1, v));
  }
  return static_cast<double>(with_neighbour) <
         kLeastWithNeighbour * static_cast<double>(cloud.points.size());
}

Result<GridFile> grid_from_e57_cloud(E57Cloud cloud, const std::filesystem::path& path) {
  if (cloud.points.empty()) return bad_input(path, "the scan of the E57 has no valid points");
  if (!cloud.structured)
    return bad_input(path,
                     "the scan of the E57 is unstructured: its points have no rowIndex and "
                     "columnIndex of a grid; export it as a structured scan, or read it as a "
                     "cloud of points");
  if (too_many_cells(cloud))
    return bad_input(path, "the grid of the scan in the E57 is " + std::to_string(cloud.width) +
                               "x" + std::to_string(cloud.height) + ", but has only " +
                               std::to_string(cloud.points.size()) +
                               " points; it was thinned out: read it as a cloud of points");
  GridFile grid = empty_grid_for(cloud);
  const std::size_t lost = fill_grid(cloud, grid);
  grid.world_from_view = cloud.world_from_view;
  grid.notes = std::move(cloud.notes);
  if (lost > 0)
    grid.notes.push_back(std::to_string(lost) +
                         " points share their place on the grid with a nearer one and were left "
                         "out");
  return grid;
}

Result<GridFile> read_e57_scan(const std::filesystem::path& path, int scan) {
  auto cloud = read_e57_cloud(path, scan);
  if (!cloud) return cloud.error();
  return grid_from_e57_cloud(*std::move(cloud), path);
}

Result<GridFile> parse_e57_scan(std::string_view content, const std::filesystem::path& path,
                                int scan) {
  auto cloud = parse_e57_cloud(content, path, scan);
  if (!cloud) return cloud.error();
  return grid_from_e57_cloud(*std::move(cloud), path);
}

}  // namespace relief
