#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/shared_surface.h"
#include "registration/posegraph/joint/joint_solver.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The fit of one pair by its matches in both directions, and what they share in the world frame;
/// not graded yet.
PairFit fit_of(const std::vector<ViewSurface>& surfaces,
               const std::vector<RigidMotion>& world_from_view, const SharedSurface& shared,
               const DirectedMatches& forward, const DirectedMatches& backward);

/// Grades pairs beside all others of the same views.
void set_pair_statuses(const std::vector<ViewSurface>& surfaces, std::vector<PairFit>& pairs);

/// For each pair the RMS of distances [unit] that views which fit stay below: what their noise and
/// spacing explain, or twice the median of all pairs if that is more.
std::vector<double> largest_fitting_rms(const std::vector<ViewSurface>& surfaces,
                                        const std::vector<PairFit>& pairs);

/// The eigenvalue below which noise alone would explain what holds the pair (R5).
double degeneracy_threshold(const ViewSurface& a, const ViewSurface& b);

}  // namespace relief::registration
