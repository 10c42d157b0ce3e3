#include "scan/io/clouds/cloud_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scan/io/clouds/cloud_lattice.h"

namespace relief {

namespace {

// [rad] A plane across the view stretches places by 1 / cos^2 there, 2.4 at 50 degrees (4 at 60);
// wider clouds get even angles.
constexpr double kPinholeHalfAngle = 50.0 * std::numbers::pi / 180.0;
// Of a few strays. Beyond 75 degrees a place on the plane is 3.7 times as far out as the middle's.
constexpr double kStrayHalfAngle = 75.0 * std::numbers::pi / 180.0;
constexpr double kStrays = 0.001;  // Of the points.
// Of a point's neighbours, those that are whole steps of a grid away: a tenth by chance. On a plane
// across a camera's own view, and no other surface, nearly all are, however wide the view is.
constexpr double kOwnPicture = 0.8;
constexpr int kSectors = 72;  // Of 5 degrees each.
// Sectors with points, of all. A view of anything but its surroundings leaves half of them empty.
constexpr double kAllAround = 0.95;

// x right and y down of a picture seen along `forward`, upright with respect to `up`.
Eigen::Matrix3d upright_axes(const Eigen::Vector3d& forward, const Eigen::Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = forward;
  axes.col(0) = forward.cross(up).normalized();
  axes.col(1) = forward.cross(axes.col(0));
  return axes;
}

Eigen::Matrix3d picture_axes(const Eigen::Vector3d& forward) {
  const bool along_y = std::abs(forward.y()) > 0.8;
  return upright_axes(forward, along_y ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY());
}

constexpr double kSector = 2.0 * std::numbers::pi / kSectors;

// Points in each sector of azimuths, about +z through the viewpoint.
std::array<std::size_t, kSectors> points_in_sectors(const Eigen::Vector3d& viewpoint,
                                                    const std::vector<Eigen::Vector3d>& points) {
  std::array<std::size_t, kSectors> counts{};
  for (const auto& point : points) {
    const double azimuth = std::atan2(point.y() - viewpoint.y(), point.x() - viewpoint.x());
    const int sector = static_cast<int>(std::floor(azimuth / kSector)) + kSectors;
    ++counts[static_cast<std::size_t>(sector % kSectors)];
  }
  return counts;
}

// The azimuth opposite to the sectors with the fewest points.
double middle_azimuth(const Eigen::Vector3d& viewpoint,
                      const std::vector<Eigen::Vector3d>& points) {
  const auto counts = points_in_sectors(viewpoint, points);
  // The middle of the longest run of sectors that hold the least.
  const std::size_t least = *std::min_element(counts.begin(), counts.end());
  int best = 0, longest = 0, run = 0;
  for (int i = 0; i < 2 * kSectors && run < kSectors; ++i) {
    run = counts[static_cast<std::size_t>(i % kSectors)] == least ? run + 1 : 0;
    if (run > longest) longest = run, best = i;
  }
  const double seam = (best + 1 - 0.5 * longest) * kSector;
  return seam + std::numbers::pi;
}

// Whether a pinhole picture along `forward` holds the points, but for a few strays.
bool lie_in_cone(const Eigen::Vector3d& viewpoint, const Eigen::Vector3d& forward,
                 const std::vector<Eigen::Vector3d>& points, double half_angle) {
  std::size_t strays = 0;
  for (const auto& point : points) {
    const double cosine = (point - viewpoint).stableNormalized().dot(forward);
    if (cosine < std::cos(kStrayHalfAngle)) return false;
    if (cosine < std::cos(half_angle)) ++strays;
  }
  return static_cast<double>(strays) <= kStrays * static_cast<double>(points.size());
}

CloudRays spherical_rays(const Eigen::Vector3d& viewpoint,
                         const std::vector<Eigen::Vector3d>& points) {
  const double middle = middle_azimuth(viewpoint, points);
  const Eigen::Vector3d forward(std::cos(middle), std::sin(middle), 0.0);
  return {CloudRays::Kind::kSpherical, viewpoint, upright_axes(forward, Eigen::Vector3d::UnitZ())};
}

bool is_about_y(const CloudRays& spherical) { return std::abs(spherical.axes(2, 2)) > 0.5; }

// Whether the points are places of a picture in rows and columns, as a wide camera takes it.
bool is_own_picture(const CloudRays& picture, const std::vector<Eigen::Vector3d>& points) {
  if (!lie_in_cone(picture.origin, picture.axes.col(2), points, kStrayHalfAngle)) return false;
  std::vector<Eigen::Vector2d> at;
  at.reserve(points.size());
  for (const auto& point : points) at.push_back(picture.project(point).head<2>());
  return part_on_lattice(at) > kOwnPicture;
}

// A projection that is a ratio of affine functions, for parallel and pinhole rays.
RationalProjection projection_to(const CloudRays& rays, const CloudLattice& lattice) {
  Eigen::Matrix2d steps;
  steps << lattice.step_u, lattice.step_v;
  const Eigen::Matrix2d inverse = steps.inverse();
  const Eigen::Vector2d offset = inverse * lattice.origin;
  const auto affine = [&](const Eigen::Vector3d& slope) {
    return Eigen::Vector4d(slope.x(), slope.y(), slope.z(), -slope.dot(rays.origin));
  };
  const Eigen::Vector4d x = affine(rays.axes.col(0)), y = affine(rays.axes.col(1)),
                        z = affine(rays.axes.col(2));
  const auto numerator = [&](Eigen::Index k) -> Eigen::Vector4d {
    return inverse(k, 0) * x + inverse(k, 1) * y - offset[k] * z;
  };
  return {numerator(0), z, numerator(1), z};
}

// A spherical projection has its sensor at the origin; the table alone has none.
Camera spherical_camera(const CloudRays& rays, const CloudLattice& lattice, Grid<Ray> table) {
  const Eigen::Vector3d forward = rays.axes.col(2);
  const SphericalProjection projection = SphericalProjection::even(
      lattice.width, lattice.height, std::atan2(forward.y(), forward.x()) - lattice.origin.x(),
      -lattice.step_u.x(), -lattice.origin.y(), -lattice.step_v.y());
  if (!rays.origin.isZero(0.0) || is_about_y(rays) || !projection.valid())
    return Camera::ray_table(std::move(table), std::optional<RationalProjection>());
  return Camera::ray_table(std::move(table), projection);
}

}  // namespace

Eigen::Vector3d CloudRays::project(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = axes.transpose() * (point - origin);
  if (kind == Kind::kParallel) return p;
  const double distance = p.norm();
  if (kind == Kind::kPinhole) return {p.x() / p.z(), p.y() / p.z(), distance};
  return {std::atan2(p.x(), p.z()), std::atan2(p.y(), std::hypot(p.x(), p.z())), distance};
}

Eigen::Vector3d CloudRays::direction(const Eigen::Vector2d& at) const {
  if (kind == Kind::kParallel) return axes.col(2);
  if (kind == Kind::kPinhole) return axes * at.homogeneous();
  const double across = std::cos(at.y());
  return axes *
         Eigen::Vector3d(across * std::sin(at.x()), std::sin(at.y()), across * std::cos(at.x()));
}

CloudRays parallel_rays(const Eigen::Vector3d& direction, const Eigen::Vector3d& centre) {
  return {CloudRays::Kind::kParallel, centre, picture_axes(direction.normalized())};
}

CloudRays rays_from(const Eigen::Vector3d& viewpoint, const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& point : points) mean += (point - viewpoint).stableNormalized();
  const Eigen::Vector3d along_z(0.0, 0.0, std::copysign(1.0, mean.z()));
  // Programs of robots let cameras look along x, with z upwards.
  const Eigen::Vector3d along_x(std::copysign(1.0, mean.x()), 0.0, 0.0);
  const CloudRays z_picture{CloudRays::Kind::kPinhole, viewpoint, picture_axes(along_z)};
  const CloudRays x_picture{CloudRays::Kind::kPinhole, viewpoint,
                            upright_axes(along_x, Eigen::Vector3d::UnitZ())};
  for (const CloudRays& picture : {z_picture, x_picture})
    if (lie_in_cone(viewpoint, picture.axes.col(2), points, kPinholeHalfAngle)) return picture;
  for (const CloudRays& picture : {z_picture, x_picture})
    if (is_own_picture(picture, points)) return picture;
  if (!(mean.norm() > 1e-6 * static_cast<double>(points.size())))
    return spherical_rays(viewpoint, points);
  const Eigen::Vector3d forward = mean.normalized();
  if (lie_in_cone(viewpoint, forward, points, kPinholeHalfAngle))
    return {CloudRays::Kind::kPinhole, viewpoint, picture_axes(forward)};
  // About +z the middle of a view along z would be a pole.
  if (lie_in_cone(viewpoint, along_z, points, kStrayHalfAngle))
    return {CloudRays::Kind::kSpherical, viewpoint, z_picture.axes};
  return spherical_rays(viewpoint, points);
}

bool surround(const std::vector<Eigen::Vector3d>& points, const CloudRays& rays) {
  if (rays.kind != CloudRays::Kind::kSpherical || is_about_y(rays)) return false;
  const auto counts = points_in_sectors(rays.origin, points);
  return static_cast<double>(std::count(counts.begin(), counts.end(), 0u)) <=
         (1.0 - kAllAround) * kSectors;
}

Camera camera_of(const CloudRays& rays, const CloudLattice& lattice, double nearest,
                 double standoff) {
  const auto in_space = [&](const Eigen::Vector2d& at) -> Eigen::Vector3d {
    return rays.axes.leftCols<2>() * at;
  };
  if (rays.kind == CloudRays::Kind::kParallel) {
    const Eigen::Vector3d start = rays.origin + (nearest - standoff) * rays.axes.col(2);
    return Camera::orthographic(lattice.width, lattice.height, start + in_space(lattice.origin),
                                in_space(lattice.step_u), in_space(lattice.step_v),
                                rays.axes.col(2));
  }
  Grid<Ray> table(lattice.width, lattice.height);
  for (int v = 0; v < lattice.height; ++v)
    for (int u = 0; u < lattice.width; ++u)
      table(u, v) = {rays.origin, rays.direction(lattice.at(u, v))};
  if (rays.kind == CloudRays::Kind::kSpherical)
    return spherical_camera(rays, lattice, std::move(table));
  return Camera::ray_table(std::move(table), projection_to(rays, lattice));
}

}  // namespace relief
