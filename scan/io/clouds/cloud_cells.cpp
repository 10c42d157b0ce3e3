#include "scan/io/clouds/cloud_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "relief/scan/range_view.h"
#include "scan/io/clouds/cloud_lattice.h"

namespace relief {

namespace {

// [spacings] along the ray: one surface is as deep over a spacing at atan 3 = 72 degrees.
constexpr double kSameSurface = 3.0;
// Of 8: then a point shows through a gap. Beside a straight edge 3 are nearer, in its corner 5.
constexpr int kNearerNeighbours = 6;
constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

}  // namespace

CloudCells::CloudCells(const PointCloudFile& cloud, const CloudRays& rays)
    : cloud_(cloud), rays_(rays) {
  projected_.reserve(cloud.points.size());
  for (const auto& point : cloud.points) projected_.push_back(rays.project(point));
}

Result<void> CloudCells::fit() {
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

void CloudCells::place_points() {
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

GridFile CloudCells::grid() const {
  const Eigen::Vector3f no_normal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
  GridFile file;
  file.points =
      Grid<Eigen::Vector3d>(lattice_.width, lattice_.height, Eigen::Vector3d::Constant(kNoSample));
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

std::size_t CloudCells::kept() const {
  return static_cast<std::size_t>(
      std::count_if(owner_.begin(), owner_.end(), [](std::uint32_t p) { return p != kFree; }));
}
double CloudCells::spacing(double distance) const {
  return rays_.scale(std::abs(distance)) * std::max(lattice_.step_u.norm(), lattice_.step_v.norm());
}

// A row beyond a pole would look to the other side.
void CloudCells::end_at_poles() {
  constexpr double kPole = 0.5 * std::numbers::pi;
  const double step = lattice_.step_v.y();
  const double before = std::max(0.0, std::ceil((-kPole - lattice_.origin.y()) / step));
  lattice_.origin += before * lattice_.step_v;
  const double last = std::floor((kPole - lattice_.origin.y()) / step);
  lattice_.height =
      std::max(2, std::min(lattice_.height - static_cast<int>(before), static_cast<int>(last) + 1));
}

// Columns of a lattice that goes all round divide a turn: none looks where another does.
void CloudCells::close_turn() {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if ((lattice_.width - 1) * lattice_.step_u.x() < kTurn) return;
  lattice_.width = std::max(2, static_cast<int>(std::lround(kTurn / lattice_.step_u.x())));
  lattice_.step_u *= kTurn / (lattice_.width * lattice_.step_u.x());
  goes_round_ = true;
}

// The cell of each point, and the points ordered by cell.
void CloudCells::find_places() {
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
    places_[i] = {static_cast<std::int32_t>(cell.x()), static_cast<std::int32_t>(cell.y()), off.x(),
                  off.y()};
    order_.push_back(static_cast<std::uint32_t>(i));
  }
  std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(places_[a].v, places_[a].u) < std::pair(places_[b].v, places_[b].u);
  });
}

std::size_t CloudCells::end_of_cell(std::size_t begin) const {
  const Place& first = places_[order_[begin]];
  std::size_t end = begin + 1;
  while (end < order_.size() && places_[order_[end]].u == first.u &&
         places_[order_[end]].v == first.v)
    ++end;
  return end;
}

float CloudCells::off_centre(std::uint32_t point) const {
  return std::hypot(places_[point].off_u, places_[point].off_v);
}

// The point of the nearest surface that is closest to the middle; the others are crowded out.
void CloudCells::place_cell(std::size_t begin, std::size_t end,
                            std::vector<std::uint32_t>& crowded) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = begin; i < end; ++i) nearest = std::min(nearest, projected_[order_[i]].z());
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
bool CloudCells::move_beside(std::uint32_t point) {
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

int CloudCells::nearer_neighbours(int u, int v) const {
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

void CloudCells::drop_what_shows_through() {
  std::vector<std::size_t> dropped;
  for (int v = 0; v < lattice_.height; ++v)
    for (int u = 0; u < lattice_.width; ++u)
      if (owner_(u, v) != kFree && nearer_neighbours(u, v) >= kNearerNeighbours)
        dropped.push_back(owner_.index(u, v));
  for (const std::size_t cell : dropped) owner_[cell] = kFree;
  hidden_ += dropped.size();
}

}  // namespace relief
