#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "registration/joint_solver.h"
#include "registration/slippage.h"
#include "registration/view_surface.h"
#include "scan/rigid_motion.h"

namespace relief {

/// What a pair of views is worth by itself.
enum class PairGrade {
  kFirm,    ///< It fits and determines all six motions.
  kSlides,  ///< It fits, but leaves motions free: other pairs have to hold them.
  kThin,    ///< It fits, but on less than a tenth of the views or 200 samples.
  kMisfit,  ///< It deviates by more than noise and sampling explain: see largest_fitting_rms().
};

/// How two views fit at the refined poses.
struct PairFit {
  std::size_t a = 0, b = 0;  ///< Indices of the views; a < b.
  double overlap = 0.0;  ///< Fraction of samples seen by the other view, mean of both directions.
  double rms = 0.0;      ///< Of the point-to-plane distances [unit].
  std::size_t correspondences = 0;  ///< Both directions together.
  PairGrade grade = PairGrade::kFirm;
  bool normal_maps = false;  ///< Whether normal maps were aligned, (R9).
  /// Motions (world frame) that this pair alone would not determine.
  std::vector<DegenerateDirection> degenerate_directions;
};

/// The fit of one pair by its matches in both directions, not graded yet.
PairFit fit_of(const std::vector<ViewSurface>& surfaces,
               const std::vector<RigidMotion>& world_from_view, const DirectedMatches& forward,
               const DirectedMatches& backward);

/// Grades pairs beside all others of the same views.
void grade_pairs(const std::vector<ViewSurface>& surfaces, std::vector<PairFit>& pairs);

/// For each pair the RMS of distances [unit] that views which fit stay below: what their noise and
/// spacing explain, or twice the median of all pairs if that is more.
std::vector<double> largest_fitting_rms(const std::vector<ViewSurface>& surfaces,
                                        const std::vector<PairFit>& pairs);

/// `firm`, `slides`, `thin` or `misfit`.
std::string_view to_string(PairGrade grade);

/// The stiffness below which noise alone would explain what holds the pair (R5).
double slip_threshold(const ViewSurface& a, const ViewSurface& b);

}  // namespace relief
