#include "fusion/mesh/decimation/face_octree.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Ends the division where many faces have the same centre.
constexpr std::size_t kDeepest = 40;

Eigen::Vector3d face_centre(const TriangleMesh& mesh, std::size_t face) {
  return (mesh.corner(face, 0) + mesh.corner(face, 1) + mesh.corner(face, 2)) / 3.0;
}

// The part of a cube, 0 to 7, that a place lies in: one bit an axis.
std::size_t octant(const FaceCube& cube, const Eigen::Vector3d& place) {
  std::size_t part = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (place[axis] >= cube.centre[axis]) part |= std::size_t{1} << axis;
  return part;
}

FaceCube part_of(const FaceCube& cube, std::size_t part) {
  FaceCube child;
  child.half_side = cube.half_side / 2.0;
  for (int axis = 0; axis < 3; ++axis)
    child.centre[axis] =
        cube.centre[axis] + (part >> axis & 1 ? child.half_side : -child.half_side);
  child.depth = cube.depth + 1;
  return child;
}

// Orders the faces of a cube by its parts, each part in the order that it had, and adds the parts
// with faces as children.
void divide(const TriangleMesh& mesh, std::size_t parent, PagedArray<std::uint32_t>& moved,
            FaceOctree& octree) {
  const FaceCube cube = octree.cubes[parent];
  std::array<std::size_t, 9> starts{};
  const std::size_t count = cube.end - cube.begin;
  const auto part_of_face = [&](std::size_t i) {
    return octant(cube, face_centre(mesh, octree.faces[cube.begin + i]));
  };
  serial_for(count, [&](std::size_t i) { ++starts[part_of_face(i) + 1]; });
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  auto next = starts;
  serial_for(count,
             [&](std::size_t i) { moved[next[part_of_face(i)]++] = octree.faces[cube.begin + i]; });
  serial_for(count, [&](std::size_t i) { octree.faces[cube.begin + i] = moved[i]; });
  for (std::size_t part = 0; part < 8; ++part) {
    if (starts[part] == starts[part + 1]) continue;
    FaceCube child = part_of(cube, part);
    child.begin = cube.begin + starts[part];
    child.end = cube.begin + starts[part + 1];
    octree.cubes[parent].children.push_back(octree.cubes.size());
    octree.cubes.push_back(std::move(child));
  }
}

}  // namespace

FaceOctree divide_faces(const TriangleMesh& mesh, std::size_t most_faces) {
  FaceOctree octree;
  octree.faces = PagedArray<std::uint32_t>(mesh.faces.size());
  serial_for(mesh.faces.size(),
             [&](std::size_t f) { octree.faces[f] = static_cast<std::uint32_t>(f); });
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  FaceCube& root = octree.cubes.emplace_back();
  root.centre = box.isEmpty() ? Eigen::Vector3d::Zero() : box.center().eval();
  root.half_side = box.isEmpty() ? 0.0 : box.sizes().maxCoeff() / 2.0;
  root.end = mesh.faces.size();
  PagedArray<std::uint32_t> moved(mesh.faces.size());
  for (std::size_t i = 0; i < octree.cubes.size(); ++i)
    if (const FaceCube& cube = octree.cubes[i];
        cube.end - cube.begin > most_faces && cube.depth < kDeepest)
      divide(mesh, i, moved, octree);
  return octree;
}

}  // namespace relief::fusion
