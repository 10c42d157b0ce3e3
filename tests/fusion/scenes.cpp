#include "tests/fusion/scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "relief/fusion/merge_views.h"

namespace relief::testing {

SignedDistance sphere_distance(double radius) {
  return [=](const Eigen::Vector3d& p) { return p.norm() - radius; };
}

SignedDistance torus_distance(double major_radius, double minor_radius) {
  return [=](const Eigen::Vector3d& p) {
    return std::hypot(p.head<2>().norm() - major_radius, p.z()) - minor_radius;
  };
}

SignedDistance box_distance(const Eigen::Vector3d& half_sizes) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector3d beyond = p.cwiseAbs() - half_sizes;
    return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
  };
}

Surface traced(SignedDistance distance) {
  return [=](const Ray& ray) -> std::optional<SurfaceHit> {
    const double speed = ray.direction.norm();
    double t = 0.0;
    for (int step = 0; step < 500; ++step) {
      const Eigen::Vector3d p = ray.at(t);
      const double d = distance(p);
      if (d > 1e4) break;
      t += d / speed;
      if (d > 1e-9) continue;
      Eigen::Vector3d normal;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d h = 1e-5 * Eigen::Vector3d::Unit(k);
        normal[k] = distance(p + h) - distance(p - h);
      }
      return SurfaceHit{t, normal.normalized()};
    }
    return std::nullopt;
  };
}

std::vector<Eigen::Vector3d> even_directions(int count) {
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count, r = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

namespace {

std::vector<RangeView> views_from(double away, const Surface& surface, int count, int size,
                                  double radius) {
  const double centre = 0.5 * (size - 1);
  const double focal = 0.5 * size * away / (1.1 * radius);
  std::vector<RangeView> views;
  for (const Eigen::Vector3d& direction : even_directions(count)) {
    views.push_back(render(surface, Camera::pinhole(size, size, {focal, focal, centre, centre}),
                           look_at(away * direction, Eigen::Vector3d::Zero())));
    views.back().name = "view" + std::to_string(views.size() - 1);
  }
  return views;
}

}  // namespace

std::vector<RangeView> views_around(const Surface& surface, int count, int size, double radius) {
  return views_from(6.0 * radius, surface, count, size, radius);
}

const TriangleMesh& torus_mesh() {
  static const TriangleMesh mesh =
      fusion::merge_views(views_around(traced(torus_distance(35.0, 12.0)), 10, 80, 50.0))
          .value()
          .mesh;
  return mesh;
}

std::vector<RangeView> near_and_far_views(double radius, double noise, double exponent) {
  const Surface ball = sphere(Eigen::Vector3d::Zero(), radius);
  std::vector<RangeView> views = views_from(4.0 * radius, ball, 12, 100, radius);
  std::vector<RangeView> far = views_from(8.0 * radius, ball, 8, 100, radius);
  for (RangeView& view : far) view.name += "far";
  views.insert(views.end(), far.begin(), far.end());
  for (std::size_t i = 0; i < views.size(); ++i)
    add_range_noise(views[i], noise * (i < 12 ? 1.0 : std::pow(2.0, exponent)),
                    static_cast<std::uint32_t>(i));
  return views;
}

namespace {

constexpr int kPoolViews = 10, kPoolSize = 36, kMostViews = 8;

class SceneRandom {
 public:
  explicit SceneRandom(std::uint32_t seed) : engine_(seed) {}
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(n)); }
  double symmetric(double most) { return most * (below(2001) - 1000) * 1e-3; }
  std::uint32_t seed() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_;
};

// A rectangle of samples is lost, or lies 10 or 20 in front of where it should.
void spoil_rectangle(RangeView& view, SceneRandom& random) {
  const int u0 = random.below(kPoolSize - 6), v0 = random.below(kPoolSize - 6);
  const int width = 2 + random.below(12), height = 2 + random.below(12), step = random.below(3);
  for (int v = v0; v < std::min(kPoolSize, v0 + height); ++v)
    for (int u = u0; u < std::min(kPoolSize, u0 + width); ++u)
      view.range(u, v) = step == 0 ? kNoSample : view.range(u, v) - 10.0 * step;
}

void spoil(RangeView& view, SceneRandom& random) {
  add_range_noise(view, 0.3 * random.below(6), random.seed());
  add_normal_noise(view, 0.03 * random.below(6), random.seed());
  RigidTangent error;
  const double turn = 0.02 * random.below(3), shift = random.below(3);
  for (int k = 0; k < 6; ++k) error[k] = random.symmetric(k < 3 ? turn : shift);
  view.world_from_view = motion_from_tangent(error) * view.world_from_view;
  for (int rectangle = random.below(4); rectangle > 0; --rectangle) spoil_rectangle(view, random);
}

}  // namespace

RandomScenes::RandomScenes() {
  const SignedDistance ball = sphere_distance(20.0);
  const std::vector<SignedDistance> shapes{
      sphere_distance(40.0), torus_distance(32.0, 10.0), box_distance({35.0, 20.0, 3.0}),
      box_distance({28.0, 25.0, 20.0}), [=](const Eigen::Vector3d& p) {
        return std::min(ball(p - Eigen::Vector3d(20, 0, 0)), ball(p + Eigen::Vector3d(20, 0, 0)));
      }};
  for (const SignedDistance& shape : shapes)
    pool_.push_back(views_around(traced(shape), kPoolViews, kPoolSize, 46.0));
}

std::vector<RangeView> RandomScenes::scene(std::uint32_t seed) const {
  SceneRandom random(seed);
  const auto& pool = pool_[seed % pool_.size()];
  std::vector<RangeView> views;
  for (int left = 1 + random.below(kMostViews); left > 0; --left) {
    if (!views.empty() && random.below(5) == 0) {
      views.push_back(
          views[static_cast<std::size_t>(random.below(static_cast<int>(views.size())))]);
      continue;
    }
    views.push_back(pool[static_cast<std::size_t>(random.below(kPoolViews))]);
    spoil(views.back(), random);
  }
  return views;
}

std::vector<fusion::NodeKey> cube_of_blocks(int side) {
  std::vector<fusion::NodeKey> blocks;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) blocks.push_back(fusion::key_of({x, y, z}));
  fusion::make_sorted_set(blocks);
  return blocks;
}

fusion::SparseField field_of(int side, const std::function<double(const fusion::Node&)>& function) {
  fusion::SparseField field({Eigen::Vector3d(1, 2, 3), 0.5}, cube_of_blocks(side), nullptr, 1.0f);
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    if (!field.active(b)) continue;
    for (int i = 0; i < fusion::kBlockNodes; ++i) {
      const fusion::Node node = field.first_node(b) + fusion::node_at_offset(i);
      const bool inner =
          (node.array() > 0).all() && (node.array() < fusion::kBlockSide * side - 1).all();
      if (inner) field.values(b)[i] = static_cast<float>(function(node));
    }
  }
  return field;
}

}  // namespace relief::testing
