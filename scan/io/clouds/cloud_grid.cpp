#include "scan/io/clouds/cloud_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

#include "relief/scan/range_view.h"
#include "scan/io/clouds/cloud_cells.h"
#include "scan/io/clouds/cloud_direction.h"
#include "scan/io/clouds/cloud_rays.h"
#include "scan/io/clouds/cloud_side.h"
#include "scan/io/clouds/normal_orientation.h"

namespace relief {

namespace {

constexpr std::size_t kLeastPoints = 12;
// Mean slope of outlines [unit per unit], 11 degrees: beyond the 0 of flat sheets. For a note only.
constexpr double kAgainstNormals = -0.2;
// Part of its points that a cloud may lose on the rays of its own sensor, which measures one point
// along each: of clouds that were tried up to 0.7 %. On rays from another place they lie at random,
// and 24 % or more were lost.
constexpr double kLostFromSensor = 0.05;
// Of a turning scanner that stands among the points: its rings of rays are uneven, and up to 12 %
// were lost.
constexpr double kLostAround = 0.15;
constexpr double kManyHidden = 0.2;  // Fraction of points that is worth a warning, no more.

std::string cloud_vector_text(const Eigen::Vector3d& vector) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g)", vector.x(), vector.y(), vector.z());
  return text;
}

std::string of_points(std::size_t count, std::size_t all) {
  return std::to_string(count) + " of " + std::to_string(all) + " points";
}

// The rays of a cloud, and what the user should know of them.
struct ChosenRays {
  CloudRays rays;
  std::string note;
  bool found = false;  // Neither given nor in the file.
  bool side_known = true;
  bool by_normals = false;     // Stored ones, not those of faces.
  bool around_origin = false;  // See CloudDirection.
};

std::string rays_text(const CloudRays& rays) {
  return rays.kind == CloudRays::Kind::kParallel
             ? "along " + cloud_vector_text(rays.axes.col(2)) + " from far off"
             : "from " + cloud_vector_text(rays.origin);
}

bool has_oriented_normals(const PointCloudFile& cloud) {
  return !cloud.normals.empty() && !cloud.unoriented_normals;
}

ChosenRays choose_rays(const PointCloudFile& cloud, const CloudGridOptions& options) {
  if (options.viewpoint) return {rays_from(*options.viewpoint, cloud.points), ""};
  if (options.direction) return {parallel_rays(*options.direction, cloud.points.front()), ""};
  if (cloud.viewpoint) {
    const CloudRays rays = rays_from(*cloud.viewpoint, cloud.points);
    return {rays, "seen " + rays_text(rays) + ", as the file says"};
  }
  const CloudDirection found = find_direction(cloud);
  return {found.rays,
          "no viewpoint is given; taken as seen " + rays_text(found.rays) + " (" + found.side + ")",
          true,
          found.side_known,
          found.side_known && has_oriented_normals(cloud) && cloud.facing.empty(),
          found.around_origin};
}

Result<void> check_cloud(const PointCloudFile& cloud, const CloudGridOptions& options) {
  const std::size_t count = cloud.points.size();
  const auto fits = [&](const auto& values) { return values.empty() || values.size() == count; };
  if (!fits(cloud.normals) || !fits(cloud.colours) || !fits(cloud.facing))
    return Error{ErrorKind::kBadInput, "the cloud has not one normal or colour for each point"};
  if (count == 0) {
    std::string what = "the cloud has no points; export the scan again";
    for (const std::string& note : cloud.notes) what += "; " + note;
    return Error{ErrorKind::kUnsolvable, what};
  }
  if (count >= std::numeric_limits<std::uint32_t>::max())
    return Error{ErrorKind::kUnsolvable,
                 "a cloud of " + std::to_string(count) + " points is too large for one view"};
  if (options.viewpoint && !options.viewpoint->allFinite())
    return Error{ErrorKind::kBadInput, "the viewpoint of the cloud is not finite"};
  if (options.direction && !(options.direction->norm() > 0.0 && options.direction->allFinite()))
    return Error{ErrorKind::kBadInput, "the direction of view of the cloud is no direction"};
  return {};
}

void note_losses(const CloudCells& cells, std::size_t all, std::vector<std::string>& notes) {
  if (cells.shared() > 0)
    notes.push_back(of_points(cells.shared(), all) + " share a ray with another and are left out");
  if (cells.hidden() > 0)
    notes.push_back(of_points(cells.hidden(), all) + " lie behind others and are left out");
  if (cells.outside() > 0)
    notes.push_back(of_points(cells.outside(), all) + " lie far from the others and are left out");
  if (static_cast<double>(cells.hidden()) > kManyHidden * static_cast<double>(all))
    notes.push_back(
        "so many hidden points mean a wrong viewpoint or a cloud of several views; give the "
        "viewpoint, or one file for each view");
}

Result<GridFile> grid_on_rays(const PointCloudFile& cloud, const CloudRays& rays, bool side_known) {
  CloudCells cells(cloud, rays);
  if (auto fitted = cells.fit(); !fitted) return fitted.error();
  cells.place_points();
  if (cells.kept() == 0)
    return Error{ErrorKind::kUnsolvable, "no point of the cloud is on a ray of its grid"};
  GridFile grid = cells.grid();
  if (!side_known && turning_away(grid.points, rays, cells.spacing(0.0)) < 0.0) {
    const Eigen::Vector3d opposite = -rays.axes.col(2);
    return grid_on_rays(cloud, parallel_rays(opposite, rays.origin), true);
  }
  note_losses(cells, cloud.points.size(), grid.notes);
  return grid;
}

// Normals of files are often turned to the origin of the frame, whatever the sensor was.
bool outlines_speak_against(const GridFile& grid, const CloudRays& rays) {
  const double spacing = (grid.camera->ray(1, 0).origin - grid.camera->ray(0, 0).origin).norm();
  return rays.kind == CloudRays::Kind::kParallel &&
         turning_away(grid.points, rays, spacing) < kAgainstNormals;
}

// A few points, in one row in their order. The ray of each is shifted to it when it is read.
GridFile row_of_points(const PointCloudFile& cloud) {
  const int width = std::max(2, static_cast<int>(cloud.points.size())), height = 2;
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(width, height, Eigen::Vector3d::Constant(kNoSample));
  std::copy(cloud.points.begin(), cloud.points.end(), grid.points.begin());
  if (!cloud.normals.empty()) {
    grid.normals = Grid<Eigen::Vector3f>(width, height,
                                         Eigen::Vector3f::Constant(static_cast<float>(kNoSample)));
    std::copy(cloud.normals.begin(), cloud.normals.end(), grid.normals.begin());
  }
  if (!cloud.colours.empty()) {
    grid.colours = Grid<Colour>(width, height, Colour{});
    std::copy(cloud.colours.begin(), cloud.colours.end(), grid.colours.begin());
  }
  grid.camera = Camera::orthographic(width, height, cloud.points.front(), Eigen::Vector3d::UnitX(),
                                     Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
  grid.notes.push_back(std::to_string(cloud.points.size()) +
                       " points are too few for a surface; they stand side by side without order");
  return grid;
}

// The cloud on rays from the origin of its frame, if these are the rays of its sensor: nearly every
// point has one of its own, unlike on the rays of `found`, if these have a grid at all. Faces and
// normals that look away from the origin speak against it.
std::optional<GridFile> seen_from_origin(const PointCloudFile& cloud,
                                         const Result<GridFile>& found) {
  const double lost = found ? lost_part(*found, cloud.points.size()) : 1.0;
  if (lost <= kLostFromSensor) return std::nullopt;
  const CloudRays rays = rays_from(Eigen::Vector3d::Zero(), cloud.points);
  const double most = surround(cloud.points, rays) ? kLostAround : kLostFromSensor;
  auto grid = grid_on_rays(cloud, rays, true);
  if (!grid || lost_part(*grid, cloud.points.size()) > std::min(most, 0.5 * lost))
    return std::nullopt;
  const bool has_sides = !cloud.facing.empty() || has_oriented_normals(cloud);
  if (has_sides && hidden_fraction(cloud, rays) > kManyHidden) return std::nullopt;
  grid->assumed_viewpoint = AssumedViewpoint::kOrigin;
  grid->notes.insert(grid->notes.begin(),
                     "no viewpoint is given; taken as seen " + rays_text(rays) +
                         " (the origin of the frame: from there each point has a ray of its own)");
  return *std::move(grid);
}

Result<GridFile> lattice_from_cloud(PointCloudFile& cloud, const CloudGridOptions& options) {
  const ChosenRays chosen = choose_rays(cloud, options);
  auto grid = grid_on_rays(cloud, chosen.rays, chosen.side_known);
  if (chosen.found && chosen.rays.kind == CloudRays::Kind::kParallel)
    if (auto from_origin = seen_from_origin(cloud, grid)) return *std::move(from_origin);
  if (!grid) return grid;
  if (chosen.found && cloud.facing.empty())
    grid->assumed_viewpoint = chosen.rays.kind == CloudRays::Kind::kParallel
                                  ? AssumedViewpoint::kFarOff
                                  : AssumedViewpoint::kOrigin;
  std::vector<std::string> notes;
  if (!chosen.side_known)
    notes.push_back("no viewpoint is given; taken as seen along " +
                    cloud_vector_text(grid->camera->ray(0, 0).direction) +
                    " from far off (a guess: the side from which outlines turn away); give the "
                    "viewpoint if this is the back");
  else if (!chosen.note.empty())
    notes.push_back(chosen.note);
  if (chosen.around_origin)
    notes.push_back(
        "the points lie all around the origin of the frame: if the sensor stood there, give the "
        "viewpoint 0 0 0 (--viewpoint 0 0 0)");
  if (chosen.by_normals && outlines_speak_against(*grid, chosen.rays))
    notes.push_back(
        "the outlines turn towards that side: it is the inside of a surface, or the normals are "
        "turned round; then give the viewpoint");
  grid->notes.insert(grid->notes.begin(), notes.begin(), notes.end());
  return grid;
}

}  // namespace

Result<GridFile> grid_from_cloud(PointCloudFile cloud, const CloudGridOptions& options) {
  if (auto sound = check_cloud(cloud, options); !sound) return sound.error();
  cloud.unoriented_normals = has_unoriented_normals(cloud);
  auto grid = cloud.points.size() < kLeastPoints ? Result<GridFile>(row_of_points(cloud))
                                                 : lattice_from_cloud(cloud, options);
  if (!grid) return grid;
  if (cloud.unoriented_normals)
    grid->notes.push_back("neighbours have opposite normals, so their signs tell no side: " +
                          of_points(orient_normals_to_sensor(*grid), cloud.points.size()) +
                          " have theirs turned to the sensor");
  grid->world_from_view = cloud.world_from_view;
  grid->notes.insert(grid->notes.begin(), cloud.notes.begin(), cloud.notes.end());
  return grid;
}

double lost_part(const GridFile& grid, std::size_t points) {
  const auto kept = std::ranges::count_if(
      grid.points, [](const Eigen::Vector3d& point) { return point.allFinite(); });
  return 1.0 - static_cast<double>(kept) / static_cast<double>(points);
}

}  // namespace relief
