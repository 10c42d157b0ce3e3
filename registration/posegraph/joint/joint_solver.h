#pragma once

#include <cstddef>
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

struct JointSolverOptions {
  int max_iterations = 2;  ///< Levenberg-Marquardt steps; few, when correspondences are renewed.
};

/// One minimisation of (R3) and (R9) over all poses with fixed correspondences: Levenberg-Marquardt
/// with the Cauchy loss and a sparse Cholesky factorisation; the terms of a directed pair make
/// seven residuals, whatever their number (R6). Each of `matches`, the largest thing there is, is
/// gone as soon as it has been taken up. Poses with `fixed` are not touched; none is if it
/// failed.
[[nodiscard]] SolverSummary solve_poses(const std::vector<ViewSurface>& surfaces,
                                        std::vector<DirectedMatches> matches,
                                        const std::vector<bool>& fixed,
                                        const JointSolverOptions& options,
                                        std::vector<RigidMotion>& world_from_view);

}  // namespace relief::registration
