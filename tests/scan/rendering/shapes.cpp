#include "tests/scan/rendering/shapes.h"

#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief::rendering::testing {

TriangleMesh sphere(double radius, const Eigen::Vector3d& centre, int divisions) {
  TriangleMesh mesh = simulation::geodesic_sphere(divisions);
  for (auto& vertex : mesh.vertices) vertex = centre + radius * vertex;
  return mesh;
}

TriangleMesh plate(double half, int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      mesh.vertices.emplace_back(half * (2.0 * i / n - 1.0), half * (2.0 * j / n - 1.0), 0.0);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh floor_and_wall(double half) {
  TriangleMesh mesh = plate(half);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(-half, 0.0, 0.0);
  mesh.vertices.emplace_back(half, 0.0, 0.0);
  mesh.vertices.emplace_back(half, 0.0, half);
  mesh.vertices.emplace_back(-half, 0.0, half);
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
  return mesh;
}

PictureCamera from_above(int width, int height, double pixel) {
  PictureCamera camera;
  camera.width = width;
  camera.height = height;
  camera.camera = Camera::orthographic(
      width, height, {-0.5 * (width - 1) * pixel, 0.5 * (height - 1) * pixel, 1000.0},
      {pixel, 0, 0}, {0, -pixel, 0}, {0, 0, -1});
  return camera;
}

}  // namespace relief::rendering::testing
