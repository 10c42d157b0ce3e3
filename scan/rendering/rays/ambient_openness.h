#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "scan/rendering/rays/ray_caster.h"

namespace relief::rendering {

struct SkyRays {
  int per_side = 4;    ///< There are per_side^2 rays, one in each cell of equal weight.
  double reach = 1.0;  ///< What is farther away does not block [unit].
  std::uint64_t seed = 1;
};

/// The share of the cosine-weighted half sphere round `normal` that is open at `point`: ambient
/// occlusion (Zhukov, Iones and Kronin 1998), by stratified random rays of `stream`. `side` is the
/// normal of the face; rays below the face are mirrored at it, so that facets of a convex surface
/// do not block each other. Both are unit vectors on the side of the sky.
double ambient_openness(const RayCaster& caster, const Eigen::Vector3d& point,
                        const Eigen::Vector3d& normal, const Eigen::Vector3d& side,
                        const SkyRays& rays, std::uint64_t stream);

}  // namespace relief::rendering
