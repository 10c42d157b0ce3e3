#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/normal_maps/normal_matches.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_views.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Correspondences from samples of one view to the surface of another.
struct DirectedMatches {
  std::size_t source = 0, target = 0;
  Correspondences found;
  NormalMatches normals;  ///< Of `found`; empty where they would add little.
};

using MatchDirectedPair = std::function<DirectedMatches(std::size_t)>;

/// Directed pairs that are matched at a time: enough for all threads. Changes no result.
inline constexpr std::size_t kMatchedAtOnce = 128;

struct JointSolverOptions {
  int max_iterations = 2;  ///< Levenberg-Marquardt steps; few, when correspondences are renewed.
};

/// One minimisation of (R3) and (R9) over all poses with fixed correspondences: Levenberg-Marquardt
/// with the Cauchy loss and a sparse Cholesky factorisation; the terms of a directed pair make
/// seven residuals, whatever their number (R6). `match` gives the correspondences of directed pairs
/// 0 to `pairs` - 1 at the poses given, from several threads at once. No more of them are held at a
/// time than are needed, since they are the largest thing there is: what is made of them lies in
/// files under a memory limit. Poses with `fixed` are not touched; none is if it failed.
[[nodiscard]] SolverSummary solve_poses(const std::vector<ViewSurface>& surfaces, std::size_t pairs,
                                        const MatchDirectedPair& match,
                                        const std::vector<bool>& fixed,
                                        const JointSolverOptions& options,
                                        std::vector<RigidMotion>& world_from_view);

}  // namespace relief::registration
