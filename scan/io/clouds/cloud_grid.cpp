#include "scan/io/clouds/cloud_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "relief/scan/range_view.h"
#include "scan/io/clouds/cloud_direction.h"
#include "scan/io/clouds/cloud_lattice.h"
#include "scan/io/clouds/cloud_rays.h"
#include "scan/io/clouds/cloud_side.h"

namespace relief {

namespace {

constexpr std::size_t kLeastPoints = 12;
// [spacings] along the ray: one surface is as deep over a spacing at atan 3 = 72 degrees.
constexpr double kSameSurface = 3.0;
// Of 8: then a point shows through a gap. Beside a straight edge 3 are nearer, in its corner 5.
constexpr int kNearerNeighbours = 6;
// Mean slope of outlines [unit per unit], 11 degrees: beyond the 0 of flat sheets. For a note only.
constexpr double kAgainstNormals = -0.2;
constexpr double kManyHidden = 0.2;  // Fraction of points that is worth a warning, no more.
constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

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
  bool side_known = true;
  bool by_normals = false;     // Stored ones, not those of faces.
  bool around_origin = false;  // See CloudDirection.
};

std::string rays_text(const CloudRays& rays) {
  return rays.kind == CloudRays::Kind::kParallel
             ? "along " + cloud_vector_text(rays.axes.col(2)) + " from far off"
             : "from " + cloud_vector_text(rays.origin);
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
          found.side_known, found.side_known && !cloud.normals.empty() && cloud.facing.empty(),
          found.around_origin};
}

// Puts points into the cells of a lattice.
class CloudCells {
 public:
  CloudCells(const PointCloudFile& cloud, const CloudRays& rays) : cloud_(cloud), rays_(rays) {
    projected_.reserve(cloud.points.size());
    for (const auto& point : cloud.points) projected_.push_back(rays.project(point));
  }

  Result<void> fit() {
    std::vector<Eigen::Vector2d> at;
    at.reserve(projected_.size());
    for (const auto& p : projected_) at.push_back(p.head<2>());
    auto lattice = fit_lattice(at, rays_.kind != CloudRays::Kind::kSpherical);
    if (!lattice) return lattice.error();
    lattice_ = *lattice;
    if (rays_.kind == CloudRays::Kind::kSpherical) {
      end_at_poles();
      close_turn();
    }
    return {};
  }

  void place_points() {
    find_places();
    owner_ = Grid<std::uint32_t>(lattice_.width, lattice_.height, kFree);
    std::vector<std::uint32_t> crowded;
    for (std::size_t begin = 0; begin < order_.size();) {
      const std::size_t end = end_of_cell(begin);
      place_cell(begin, end, crowded);
      begin = end;
    }
    for (const std::uint32_t point : crowded)
      if (!move_beside(point)) ++shared_;
    drop_what_shows_through();
  }

  GridFile grid() const {
    const Eigen::Vector3f no_normal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
    GridFile file;
    file.points = Grid<Eigen::Vector3d>(lattice_.width, lattice_.height,
                                        Eigen::Vector3d::Constant(kNoSample));
    if (!cloud_.normals.empty())
      file.normals = Grid<Eigen::Vector3f>(lattice_.width, lattice_.height, no_normal);
    if (!cloud_.colours.empty()) file.colours = Grid<Colour>(lattice_.width, lattice_.height);
    double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
    for (std::size_t cell = 0; cell < owner_.size(); ++cell) {
      if (owner_[cell] == kFree) continue;
      file.points[cell] = cloud_.points[owner_[cell]];
      if (!cloud_.normals.empty()) file.normals[cell] = cloud_.normals[owner_[cell]];
      if (!cloud_.colours.empty()) file.colours[cell] = cloud_.colours[owner_[cell]];
      nearest = std::min(nearest, projected_[owner_[cell]].z());
      farthest = std::max(farthest, projected_[owner_[cell]].z());
    }
    const double standoff = std::max(farthest - nearest, spacing(nearest));
    file.camera = camera_of(rays_, lattice_, nearest, standoff);
    return file;
  }

  std::size_t kept() const {
    return static_cast<std::size_t>(
        std::count_if(owner_.begin(), owner_.end(), [](std::uint32_t p) { return p != kFree; }));
  }
  // The largest distance between neighbouring places at a distance from the sensor [unit].
  double spacing(double distance) const {
    return rays_.scale(std::abs(distance)) *
           std::max(lattice_.step_u.norm(), lattice_.step_v.norm());
  }

  std::size_t shared() const { return shared_; }
  std::size_t hidden() const { return hidden_; }
  std::size_t outside() const { return outside_; }

 private:
  // A row beyond a pole would look to the other side.
  void end_at_poles() {
    constexpr double kPole = 0.5 * std::numbers::pi;
    const double step = lattice_.step_v.y();
    const double before = std::max(0.0, std::ceil((-kPole - lattice_.origin.y()) / step));
    lattice_.origin += before * lattice_.step_v;
    const double last = std::floor((kPole - lattice_.origin.y()) / step);
    lattice_.height = std::max(
        2, std::min(lattice_.height - static_cast<int>(before), static_cast<int>(last) + 1));
  }

  // Columns of a lattice that goes all round divide a turn: none looks where another does.
  void close_turn() {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    if ((lattice_.width - 1) * lattice_.step_u.x() < kTurn) return;
    lattice_.width = std::max(2, static_cast<int>(std::lround(kTurn / lattice_.step_u.x())));
    lattice_.step_u *= kTurn / (lattice_.width * lattice_.step_u.x());
    goes_round_ = true;
  }

  struct Place {
    std::int32_t u = 0, v = 0;
    float off_u = 0.0f, off_v = 0.0f;  // From the middle of the cell, in steps.
  };

  // The cell of each point, and the points ordered by cell.
  void find_places() {
    Eigen::Matrix2d steps;
    steps << lattice_.step_u, lattice_.step_v;
    const Eigen::Matrix2d inverse = steps.inverse();
    places_.resize(projected_.size());
    for (std::size_t i = 0; i < projected_.size(); ++i) {
      const Eigen::Vector2d at = inverse * (projected_[i].head<2>() - lattice_.origin);
      Eigen::Vector2d cell(std::round(at.x()), std::round(at.y()));
      const Eigen::Vector2f off = (at - cell).cast<float>();
      if (goes_round_) cell.x() -= lattice_.width * std::floor(cell.x() / lattice_.width);
      if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < lattice_.width &&
            cell.y() < lattice_.height)) {
        ++outside_;
        continue;
      }
      places_[i] = {static_cast<std::int32_t>(cell.x()), static_cast<std::int32_t>(cell.y()),
                    off.x(), off.y()};
      order_.push_back(static_cast<std::uint32_t>(i));
    }
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(places_[a].v, places_[a].u) < std::pair(places_[b].v, places_[b].u);
    });
  }

  std::size_t end_of_cell(std::size_t begin) const {
    const Place& first = places_[order_[begin]];
    std::size_t end = begin + 1;
    while (end < order_.size() && places_[order_[end]].u == first.u &&
           places_[order_[end]].v == first.v)
      ++end;
    return end;
  }

  float off_centre(std::uint32_t point) const {
    return std::hypot(places_[point].off_u, places_[point].off_v);
  }

  // The point of the nearest surface that is closest to the middle; the others are crowded out.
  void place_cell(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& crowded) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = begin; i < end; ++i)
      nearest = std::min(nearest, projected_[order_[i]].z());
    const double limit = nearest + kSameSurface * spacing(nearest);
    std::uint32_t best = kFree;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t point = order_[i];
      if (projected_[point].z() > limit) continue;
      if (best == kFree || off_centre(point) < off_centre(best)) best = point;
    }
    const Place& place = places_[best];
    owner_(place.u, place.v) = best;
    for (std::size_t i = begin; i < end; ++i) {
      if (order_[i] == best) continue;
      if (projected_[order_[i]].z() > limit)
        ++hidden_;
      else
        crowded.push_back(order_[i]);
    }
  }

  // To the free cell beside its own that is closest to it, on its own side.
  bool move_beside(std::uint32_t point) {
    const Place& place = places_[point];
    const int du = place.off_u < 0.0f ? -1 : 1, dv = place.off_v < 0.0f ? -1 : 1;
    const bool first_u = std::abs(place.off_u) >= std::abs(place.off_v);
    const std::array<std::array<int, 2>, 2> moves{
        {{first_u ? du : 0, first_u ? 0 : dv}, {first_u ? 0 : du, first_u ? dv : 0}}};
    for (const auto& [u, v] : moves) {
      if (!owner_.contains(place.u + u, place.v + v)) continue;
      std::uint32_t& owner = owner_(place.u + u, place.v + v);
      if (owner != kFree) continue;
      owner = point;
      return true;
    }
    return false;
  }

  int nearer_neighbours(int u, int v) const {
    const double depth = projected_[owner_(u, v)].z();
    const double limit = depth - kSameSurface * spacing(depth);
    int nearer = 0;
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du)
        if (owner_.contains(u + du, v + dv) && owner_(u + du, v + dv) != kFree &&
            projected_[owner_(u + du, v + dv)].z() < limit)
          ++nearer;
    return nearer;
  }

  void drop_what_shows_through() {
    std::vector<std::size_t> dropped;
    for (int v = 0; v < lattice_.height; ++v)
      for (int u = 0; u < lattice_.width; ++u)
        if (owner_(u, v) != kFree && nearer_neighbours(u, v) >= kNearerNeighbours)
          dropped.push_back(owner_.index(u, v));
    for (const std::size_t cell : dropped) owner_[cell] = kFree;
    hidden_ += dropped.size();
  }

  const PointCloudFile& cloud_;
  CloudRays rays_;
  CloudLattice lattice_;
  bool goes_round_ = false;  // The column after the last one is the first.
  std::vector<Eigen::Vector3d> projected_;
  std::vector<Place> places_;
  std::vector<std::uint32_t> order_;  // Points inside the lattice, cell by cell.
  Grid<std::uint32_t> owner_;         // The point of each cell.
  std::size_t shared_ = 0, hidden_ = 0, outside_ = 0;
};

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
  if (count >= kFree)
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

Result<GridFile> lattice_from_cloud(PointCloudFile& cloud, const CloudGridOptions& options) {
  const ChosenRays chosen = choose_rays(cloud, options);
  auto grid = grid_on_rays(cloud, chosen.rays, chosen.side_known);
  if (!grid) return grid;
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
        "viewpoint 0 0 0");
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
  auto grid = cloud.points.size() < kLeastPoints ? Result<GridFile>(row_of_points(cloud))
                                                 : lattice_from_cloud(cloud, options);
  if (!grid) return grid;
  grid->world_from_view = cloud.world_from_view;
  grid->notes.insert(grid->notes.begin(), cloud.notes.begin(), cloud.notes.end());
  return grid;
}

}  // namespace relief
