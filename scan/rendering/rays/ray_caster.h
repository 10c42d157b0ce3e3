#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>

#include "relief/scan/projections.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::rendering {

/// Rays against the faces of a mesh, by Embree. Its coordinates are floats: inside, the mesh is
/// moved to the origin and scaled to radius 1, and rays start beside it, so that a large distance
/// from the origin costs nothing. Queries may run in several threads.
class RayCaster {
 public:
  /// kBadInput, kUnsolvable as MeshScene::of. The same for any number of threads.
  static Result<RayCaster> of(const TriangleMesh& mesh);

  struct Hit {
    std::uint32_t face = 0;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();  ///< Barycentric, of the corners.
    double range = 0.0;                                 ///< t of the ray.
  };
  /// The first crossing of the ray with the mesh, from either side; of the whole line, from its
  /// far end, unless `from_origin`.
  std::optional<Hit> first_hit(const Ray& ray, bool from_origin) const;

  /// Whether the mesh is within `reach` [unit] of `point` in a direction (a unit vector). `side` is
  /// the normal of the surface at `point`, on the side of which the ray starts.
  bool is_blocked(const Eigen::Vector3d& point, const Eigen::Vector3d& side,
                  const Eigen::Vector3d& direction, double reach) const;

 private:
  struct Embree;
  std::shared_ptr<const Embree> embree_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 1.0;
};

}  // namespace relief::rendering
