#include "fusion/holes/plates/cotangent_laplacian.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Contours have slivers. A face counts as no thinner than this against its longest side, which
// bounds its cotangents by 20 (40 with half of it), and so the condition of the system.
constexpr double kLeastThickness = 0.05;

}  // namespace

std::unordered_map<std::uint32_t, int> edges_from(std::vector<std::uint32_t> start, int most,
                                                  const TriangleMesh& mesh,
                                                  const FacesAround& around) {
  std::unordered_map<std::uint32_t, int> edges;
  for (const std::uint32_t v : start) edges.emplace(v, 0);
  for (int distance = 1; distance <= most; ++distance) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t v : start)
      around.visit(v, [&](std::uint32_t face) {
        for (const std::uint32_t other : mesh.faces[face])
          if (edges.emplace(other, distance).second) next.push_back(other);
      });
    start = std::move(next);
  }
  return edges;
}

FaceShape shape_of(const TriangleMesh& mesh, std::uint32_t face) {
  FaceShape shape;
  std::array<Eigen::Vector3d, 3> sides;  // opposite to each corner
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) {
    sides[static_cast<std::size_t>(k)] =
        mesh.corner(face, (k + 2) % 3) - mesh.corner(face, (k + 1) % 3);
    longest = std::max(longest, sides[static_cast<std::size_t>(k)].squaredNorm());
  }
  const double twice_area = std::max(sides[0].cross(sides[1]).norm(), kLeastThickness * longest);
  for (std::size_t k = 0; k < 3; ++k)
    shape.cotangents[k] = -sides[(k + 1) % 3].dot(sides[(k + 2) % 3]) / twice_area;
  shape.area = 0.5 * twice_area;
  return shape;
}

FacesAround::FacesAround(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted)
    : first_(mesh.vertices.size() + 2) {
  const auto for_wanted = [&](const auto& visit) {
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      for (const std::uint32_t v : mesh.faces[f])
        if (wanted[v]) visit(v, static_cast<std::uint32_t>(f));
    });
  };
  // Until all faces are there, the beginning of a vertex is one place farther.
  for_wanted([&](std::uint32_t v, std::uint32_t) { ++first_[v + 2]; });
  std::uint32_t count = 0;
  serial_for(first_.size(), [&](std::size_t v) { first_[v] = count += first_[v]; });
  faces_ = PagedArray<std::uint32_t>(count);
  for_wanted([&](std::uint32_t v, std::uint32_t f) { faces_[first_[v + 1]++] = f; });
}

double area_at(const TriangleMesh& mesh, const FacesAround& around, std::uint32_t vertex) {
  double area = 0.0;
  around.visit(vertex, [&](std::uint32_t face) { area += shape_of(mesh, face).area / 3.0; });
  return area;
}

}  // namespace relief::fusion
