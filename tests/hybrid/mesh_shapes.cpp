#include "tests/hybrid/mesh_shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "scan/base/counter_random.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief::testing {

TriangleMesh plane_mesh(int size) {
  TriangleMesh mesh;
  const auto vertex = [&](int x, int y) { return static_cast<std::uint32_t>(y * (size + 1) + x); };
  for (int y = 0; y <= size; ++y)
    for (int x = 0; x <= size; ++x) mesh.vertices.emplace_back(x, y, 0.0);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      mesh.faces.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1)});
      mesh.faces.push_back({vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
    }
  }
  return mesh;
}

TriangleMesh box_mesh(const Eigen::Vector3d& size, double spacing) {
  TriangleMesh mesh;
  const Eigen::Vector3i cells = (size / spacing).array().round().max(1.0).cast<int>();
  std::map<std::tuple<int, int, int>, std::uint32_t> named;
  const auto vertex = [&](const Eigen::Vector3i& place) {
    const auto [entry, added] = named.try_emplace({place.x(), place.y(), place.z()},
                                                  static_cast<std::uint32_t>(named.size()));
    if (added)
      mesh.vertices.push_back(
          size.cwiseProduct(place.cast<double>().cwiseQuotient(cells.cast<double>())) - 0.5 * size);
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (const int end : {0, cells[axis]}) {
      for (int i = 0; i < cells[a]; ++i) {
        for (int j = 0; j < cells[b]; ++j) {
          const auto corner = [&](int di, int dj) {
            Eigen::Vector3i place;
            place[axis] = end;
            place[a] = i + di;
            place[b] = j + dj;
            return vertex(place);
          };
          const std::array<std::uint32_t, 4> c{corner(0, 0), corner(1, 0), corner(1, 1),
                                               corner(0, 1)};
          if (end > 0) {
            mesh.faces.push_back({c[0], c[1], c[2]});
            mesh.faces.push_back({c[0], c[2], c[3]});
          } else {
            mesh.faces.push_back({c[0], c[2], c[1]});
            mesh.faces.push_back({c[0], c[3], c[2]});
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh torus_mesh(double radius, double tube, int around, int across) {
  TriangleMesh mesh;
  const auto vertex = [&](int i, int j) {
    return static_cast<std::uint32_t>((i % around) * across + j % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2.0 * std::numbers::pi * i / around;
      const double b = 2.0 * std::numbers::pi * j / across;
      const double from_axis = radius + tube * std::cos(b);
      mesh.vertices.emplace_back(from_axis * std::cos(a), from_axis * std::sin(a),
                                 tube * std::sin(b));
      mesh.faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.faces.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return mesh;
}

double torus_distance(const Eigen::Vector3d& point, double radius, double tube) {
  return std::hypot(std::hypot(point.x(), point.y()) - radius, point.z()) - tube;
}

TriangleMesh sphere_mesh(double radius, int divisions) {
  TriangleMesh mesh = simulation::geodesic_sphere(divisions);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

hybrid::MeshNormals exact_normals(const TriangleMesh& exact, double spacing, double sigma) {
  hybrid::MeshNormals normals;
  normals.normals = vertex_normals(exact);
  normals.sigma.assign(exact.vertices.size(), static_cast<float>(sigma));
  normals.views.assign(exact.vertices.size(), 1);
  normals.sample_spacing = spacing;
  normals.measured = exact.vertices.size();
  return normals;
}

void add_vertex_noise(TriangleMesh& mesh, double sigma, std::uint64_t seed) {
  const PagedVector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const CounterRandom random(seed, 0);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] += sigma * random.normal(i) * normals[i].cast<double>();
  mesh.quality.assign(mesh.vertices.size(), static_cast<float>(sigma));
}

}  // namespace relief::testing
