#include "scan/simulation/objects/built_in_object.h"

#include <array>
#include <cmath>
#include <numbers>

#include "scan/base/parallel.h"
#include "scan/simulation/objects/dual.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief::simulation {

namespace {

using std::cos;
using std::exp;
using std::sin;
using std::sqrt;

// Everything below is a function of the unit direction (x, y, z), written once for T = double and
// T = Dual. Heights and depths are in millimetres; widths on the sphere are chords of the unit
// sphere, where 0.025 is about one millimetre on the owl.
template <typename T>
struct Direction {
  T x, y, z;
};

template <typename T>
T square(const T& a) {
  return a * a;
}

// (1 - s)^3 where s < 1, else 0: the profile of all bumps, twice continuously differentiable.
template <typename T>
T fall_off(const T& s) {
  if (value_of(s) >= 1.0) return T(0.0);
  const T a = 1.0 - s;
  return a * a * a;
}

// 0 below `from`, 1 above `to`, a quintic between.
template <typename T>
T smooth_step(double from, double to, const T& a) {
  const T s = (a - from) / (to - from);
  if (value_of(s) <= 0.0) return T(0.0);
  if (value_of(s) >= 1.0) return T(1.0);
  return s * s * s * (s * (6.0 * s - 15.0) + 10.0);
}

// Squared chord between the direction and a fixed unit vector.
template <typename T>
T chord_squared(const Direction<T>& d, const Eigen::Vector3d& c) {
  return 2.0 - 2.0 * (c.x() * d.x + c.y() * d.y + c.z() * d.z);
}

// A place on the sphere with two tangent axes.
struct Place {
  Eigen::Vector3d centre, across, along;

  // `along` is the tangent closest to `towards`.
  Place(const Eigen::Vector3d& c, const Eigen::Vector3d& towards)
      : centre(c.normalized()),
        across(towards.cross(centre).normalized()),
        along(centre.cross(across)) {}
};

template <typename T>
T dot(const Direction<T>& d, const Eigen::Vector3d& a) {
  return a.x() * d.x + a.y() * d.y + a.z() * d.z;
}

// (across / half_width)^2 + (along / half_length)^2 about a place; 2 on the far side.
template <typename T>
T elliptic(const Direction<T>& d, const Place& place, double half_width, double half_length) {
  if (value_of(dot(d, place.centre)) <= 0.0) return T(2.0);
  return square(dot(d, place.across) * (1.0 / half_width)) +
         square(dot(d, place.along) * (1.0 / half_length));
}

// An egg that stands on a flat foot: the eighth-power blend of an ellipsoid and a half space.
template <typename T>
T body(const Direction<T>& d) {
  const T egg =
      square(d.x * (1.0 / 38.0)) + square(d.y * (1.0 / 35.0)) + square(d.z * (1.0 / 50.0));
  T blend = square(square(egg));
  if (value_of(d.z) < 0.0) blend = blend + square(square(square(d.z * (1.0 / 47.0))));
  const T radius = 1.0 / sqrt(sqrt(sqrt(blend)));
  return radius - 2.4 * fall_off(square((d.z - 0.34) * (1.0 / 0.36)));  // the neck
}

// Paired features are evaluated once at |x|; they vanish before they reach the plane x = 0.
template <typename T>
T ears(const Direction<T>& d) {
  static const Place kEar({0.46, -0.10, 0.88}, {1, 0, 0});
  return 11.0 * fall_off(elliptic(d, kEar, 0.33, 0.40));
}

template <typename T>
T eyes(const Direction<T>& d) {
  static const Eigen::Vector3d kEye = Eigen::Vector3d(0.335, -0.72, 0.60).normalized();
  const T rho2 = chord_squared(d, kEye);
  const T disc = fall_off(rho2 * (1.0 / square(0.34)));
  if (value_of(disc) == 0.0) return T(0.0);
  const auto ring = [&](double radius, double half_width) {
    return fall_off(square((rho2 - square(radius)) * (0.5 / (radius * half_width))));
  };
  // Lids, ball, iris and pupil, and fine rings of 1.7 mm in the facial disc. The cosine of a
  // distance is smooth at its centre.
  const T rho = sqrt(rho2 + 1e-12);
  return 1.1 * ring(0.255, 0.075) - 2.0 * disc + 3.2 * fall_off(rho2 * (1.0 / square(0.17))) -
         0.30 * ring(0.080, 0.022) - 0.25 * fall_off(rho2 * (1.0 / square(0.035))) +
         0.14 * smooth_step(0.02, 0.3, disc) * (1.0 - fall_off(rho2 * (1.0 / square(0.2)))) *
             cos(rho * (2.0 * std::numbers::pi / 0.044));
}

template <typename T>
T wings(const Direction<T>& d) {
  static const Place kWing({0.93, 0.22, -0.22}, {-0.25, 0.55, -1.0});
  const T s = elliptic(d, kWing, 0.46, 0.80);
  if (value_of(s) >= 1.0) return T(0.0);
  const T shape = 1.0 - smooth_step(0.62, 1.0, s);
  const T across = dot(d, kWing.across), along = dot(d, kWing.along);
  // Flight feathers fan out towards the tip; barbs of 1.1 mm run slantwise over them.
  const T fan = (across / (1.25 + 0.5 * along)) * (2.0 * std::numbers::pi / 0.085);
  const T barbs = (along + 0.6 * across) * (2.0 * std::numbers::pi / 0.032);
  return shape * (3.2 + 0.45 * cos(fan) + 0.035 * cos(barbs));
}

template <typename T>
T beak(const Direction<T>& d) {
  static const Place kBeak({0.0, -0.85, 0.50}, {0, 0, 1});
  return 5.5 * fall_off(elliptic(d, kBeak, 0.15, 0.24));
}

// Scalloped plumage of the breast: wave crests bent by a second wave.
template <typename T>
T plumage(const Direction<T>& d) {
  static const Place kBreast({0.0, -0.92, -0.36}, {0, 0, 1});
  const T s = elliptic(d, kBreast, 0.62, 0.66);
  if (value_of(s) >= 1.0) return T(0.0);
  const T shape = 1.0 - smooth_step(0.6, 1.0, s);
  const T across = dot(d, kBreast.across) * (2.0 * std::numbers::pi / 0.15);
  const T along = dot(d, kBreast.along) * (2.0 * std::numbers::pi / 0.12);
  const T row = along + 1.1 * cos(across);
  return shape * (1.0 + 0.36 * cos(row) + 0.10 * sin(2.0 * row));
}

// A resolution chart on the back: waves of constant slope whose length falls tenfold downwards.
template <typename T>
T chirp(const Direction<T>& d) {
  static const Place kBack({0.0, 1.0, -0.05}, {0, 0, 1});
  const T s = elliptic(d, kBack, 0.42, 0.66);
  if (value_of(s) >= 1.0) return T(0.0);
  const T shape = 1.0 - smooth_step(0.65, 1.0, s);
  // [radii of 40 mm]: the longest wave is 8 mm.
  constexpr double kTop = 0.6, kHeight = 1.2, kLongest = 8.0 / 40.0;
  const T shrink = exp((kTop - d.z) * (std::numbers::ln10 / kHeight));  // 1 at the top, then to 10
  const T phase = shrink * (2.0 * std::numbers::pi / kLongest * kHeight / std::numbers::ln10);
  return shape * (0.8 + 0.42 * cos(phase) / shrink);
}

// Three toes a foot.
template <typename T>
T toes(const Direction<T>& d) {
  if (value_of(d.z) > -0.6) return T(0.0);
  static const std::array<Place, 3> kToes = {Place({0.17, -0.52, -0.83}, {0, -1, -0.6}),
                                             Place({0.29, -0.50, -0.83}, {0.15, -1, -0.6}),
                                             Place({0.41, -0.44, -0.83}, {0.3, -1, -0.6})};
  T height(0.0);
  for (const Place& toe : kToes) height = height + 2.6 * fall_off(elliptic(d, toe, 0.065, 0.17));
  return height;
}

// A circle of pits of 1.4 mm on the nape.
template <typename T>
T pits(const Direction<T>& d) {
  static const Eigen::Vector3d kNape = Eigen::Vector3d(0.0, 0.62, 0.78).normalized();
  constexpr double kRow = 0.36, kRadius = 0.018;  // [radii of 40 mm]: pits of 1.4 mm.
  const T rho2 = chord_squared(d, kNape);
  if (std::abs(value_of(rho2) - square(kRow)) > 2.1 * kRow * kRadius) return T(0.0);
  static const std::array<Eigen::Vector3d, 24> kPits = [] {
    std::array<Eigen::Vector3d, 24> centres;
    const Place nape(kNape, {0, 0, 1});
    const double away = std::asin(kRow / 2.0) * 2.0;
    for (std::size_t i = 0; i < centres.size(); ++i) {
      const double turn = 2.0 * std::numbers::pi * static_cast<double>(i) / 24.0;
      centres[i] = std::cos(away) * kNape +
                   std::sin(away) * (std::cos(turn) * nape.along + std::sin(turn) * nape.across);
    }
    return centres;
  }();
  T depth(0.0);
  for (const auto& pit : kPits)
    depth = depth - 0.18 * fall_off(chord_squared(d, pit) * (1.0 / square(kRadius)));
  return depth;
}

// The letter R engraved under the foot, strokes 1.4 mm wide; coordinates in millimetres there.
template <typename T>
T letter(const Direction<T>& d) {
  if (value_of(d.z) > -0.9) return T(0.0);
  struct Stroke {
    double x0, y0, x1, y1;
  };
  static constexpr std::array<Stroke, 6> kStrokes = {{{-4, -7, -4, 7},
                                                      {-4, 7, 2, 7},
                                                      {2, 7, 4, 3.5},
                                                      {4, 3.5, 2, 0},
                                                      {2, 0, -4, 0},
                                                      {0, 0, 5, -7}}};
  const T x = -46.0 * d.x / d.z, y = 46.0 * d.y / d.z;  // as seen from below
  T product(1.0);
  for (const Stroke& stroke : kStrokes) {
    const double ex = stroke.x1 - stroke.x0, ey = stroke.y1 - stroke.y0;
    const T px = x - stroke.x0, py = y - stroke.y0;
    T along = (px * ex + py * ey) * (1.0 / (ex * ex + ey * ey));
    if (value_of(along) < 0.0) along = T(0.0);
    if (value_of(along) > 1.0) along = T(1.0);
    const T distance2 = square(px - along * ex) + square(py - along * ey);
    product = product * (1.0 - fall_off(distance2 * (1.0 / square(0.7))));
  }
  return -0.22 * (1.0 - product);  // the union of the strokes
}

template <typename T>
Direction<T> mirrored(const Direction<T>& d) {
  return {value_of(d.x) < 0.0 ? -d.x : d.x, d.y, d.z};
}

// The head is turned by 25 degrees against the body.
template <typename T>
Direction<T> turned_head(const Direction<T>& d) {
  if (value_of(d.z) < 0.15) return d;
  const T angle = (25.0 * std::numbers::pi / 180.0) * smooth_step(0.15, 0.50, d.z);
  const T c = cos(angle), s = sin(angle);
  return {c * d.x + s * d.y, c * d.y - s * d.x, d.z};
}

template <typename T>
T owl_radius(const Direction<T>& unturned) {
  const Direction<T> d = turned_head(unturned);
  const Direction<T> m = mirrored(d);
  return body(d) + ears(m) + eyes(m) + beak(d) + plumage(unturned) + wings(mirrored(unturned)) +
         chirp(unturned) + toes(m) + pits(d) + letter(d);
}

// Equation (S1).
template <typename T>
T owl_value(const Direction<T>& p) {
  const T norm = sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  return norm - owl_radius<T>({p.x / norm, p.y / norm, p.z / norm});
}

double value_at(const Eigen::Vector3d& p) { return owl_value<double>({p.x(), p.y(), p.z()}); }

Eigen::Vector3d gradient_at(const Eigen::Vector3d& p) {
  return owl_value<Dual>({{p.x(), Eigen::Vector3d::UnitX()},
                          {p.y(), Eigen::Vector3d::UnitY()},
                          {p.z(), Eigen::Vector3d::UnitZ()}})
      .gradient;
}

}  // namespace

AnalyticSurface built_in_object() {
  AnalyticSurface surface;
  surface.value = value_at;
  surface.gradient = gradient_at;
  surface.bounding_radius = 58.0;
  surface.lipschitz = 2.75;
  return surface;
}

double built_in_radius(const Eigen::Vector3d& direction) {
  return owl_radius<double>({direction.x(), direction.y(), direction.z()});
}

TriangleMesh built_in_truth_mesh(int divisions) {
  TriangleMesh mesh = geodesic_sphere(divisions);
  mesh.normals.resize(mesh.vertices.size());
  parallel_for(mesh.vertices.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      mesh.vertices[i] *= built_in_radius(mesh.vertices[i]);
      mesh.normals[i] = gradient_at(mesh.vertices[i]).normalized().cast<float>();
    }
  });
  return mesh;
}

}  // namespace relief::simulation
