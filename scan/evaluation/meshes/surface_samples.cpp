#include "scan/evaluation/meshes/surface_samples.h"

#include <algorithm>
#include <cmath>

#include "scan/base/counter_random.h"

namespace relief::evaluation {

namespace {

// Uniform over the triangle from two uniform numbers (Turk 1990).
Eigen::Vector3d uniform_weights(double a, double b) {
  const double root = std::sqrt(a);
  return {1.0 - root, root * (1.0 - b), root * b};
}

}  // namespace

std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count,
                                          std::uint64_t seed) {
  std::vector<SurfaceSample> samples;
  const double area = surface_area(mesh);
  if (!(area > 0.0)) return samples;
  samples.reserve(count);
  const CounterRandom random(seed, 0);
  std::uint32_t face = 0;
  double before = 0.0, here = 0.5 * face_cross(mesh, 0).norm();
  for (std::size_t i = 0; i < count; ++i) {
    const double place =
        area * (static_cast<double>(i) + random.uniform(3 * i)) / static_cast<double>(count);
    while (before + here < place && face + 1 < mesh.faces.size()) {
      before += here;
      here = 0.5 * face_cross(mesh, ++face).norm();
    }
    samples.push_back(
        {face, uniform_weights(random.uniform(3 * i + 1), random.uniform(3 * i + 2))});
  }
  return samples;
}

Eigen::Vector3d point_at(const TriangleMesh& mesh, const SurfaceSample& sample) {
  return sample.weights[0] * mesh.corner(sample.face, 0) +
         sample.weights[1] * mesh.corner(sample.face, 1) +
         sample.weights[2] * mesh.corner(sample.face, 2);
}

}  // namespace relief::evaluation
