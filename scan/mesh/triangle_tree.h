#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/projections.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief {

/// The point of a triangle closest to a point.
struct TrianglePoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Barycentric weights of the corners; exactly 0 off the corners or edge that the point lies on.
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
};

TrianglePoint closest_on_triangle(const Eigen::Vector3d& query, const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// A hierarchy of boxes over the faces of a mesh, for exact closest points and first ray hits.
/// Keeps a reference to the mesh, which must outlive it unchanged. Queries are const and may run in
/// several threads.
class TriangleTree {
 public:
  /// The same for any number of threads.
  explicit TriangleTree(const TriangleMesh& mesh);

  struct Closest {
    std::uint32_t face = 0;
    TrianglePoint on_face;
    double distance = std::numeric_limits<double>::infinity();  ///< [unit]
  };
  /// The closest point of the mesh within `max_distance`; nothing if there is none.
  std::optional<Closest> closest(
      const Eigen::Vector3d& query,
      double max_distance = std::numeric_limits<double>::infinity()) const;

  struct Hit {
    std::uint32_t face = 0;
    double range = 0.0;  ///< t of the ray, > 0.
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  };
  /// The first crossing of a ray with the mesh, from either side. Edges belong to both faces: a ray
  /// never slips through between them.
  std::optional<Hit> first_hit(const Ray& ray) const;

  /// Calls `visit(f, g)` for pairs of faces whose boxes meet, until it returns false. The faces
  /// have an order of the tree's own; f is one of [begin, end) in it and g comes after f, so that
  /// ranges which cover all faces together give every pair once.
  void visit_box_overlaps(std::size_t begin, std::size_t end,
                          const std::function<bool(std::uint32_t f, std::uint32_t g)>& visit) const;

  const TriangleMesh& mesh() const { return *mesh_; }

 private:
  // Depth first: the left child follows its parent.
  struct Node {
    Eigen::Vector3d low, high;           // Of the box.
    std::uint32_t begin = 0, count = 0;  // faces of a leaf; count 0: inner node
    std::uint32_t end = 0;               // of the faces below
    std::uint32_t right = 0;

    Eigen::AlignedBox3d box() const { return {low, high}; }
    void set_box(const Eigen::AlignedBox3d& box) { low = box.min(), high = box.max(); }
  };

  struct Part;  // Of the faces, and the first of their nodes.

  Eigen::AlignedBox3d face_box(std::uint32_t face) const;
  using Centres = PagedArray<Eigen::Vector3d>;  // Of the faces.
  Eigen::AlignedBox3d build(const Part& part, const Centres& centres);
  std::array<Part, 2> halve(const Part& part, const Centres& centres);

  const TriangleMesh* mesh_;
  PagedArray<std::uint32_t> faces_;
  PagedArray<Node> nodes_;
};

}  // namespace relief
