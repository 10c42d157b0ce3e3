#pragma once

#include <vector>

#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Given poses, world from view, beside those that refining made of them. Refining minimises
/// distances, whatever made these: some given poses are better kept.
class GivenAndRefined {
 public:
  /// All but the last outlive it. Views that are kExcluded take no part.
  GivenAndRefined(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& given,
                  const std::vector<RigidMotion>& refined, const std::vector<ViewRole>& roles,
                  Association association);

  /// Free views with less than half of the overlap left that they had, with whichever views. Of few
  /// or coarse samples distances may be least where hardly any are left to compare.
  std::vector<bool> views_without_overlap() const;

  /// Free views that lie on each other as if they were seen from one place, to 0.2 radii, and were
  /// twice as far apart: farther than refining looks for partners. What stands still before the
  /// sensor does so, and a body of revolution, which shares most when seen within the same outline.
  std::vector<bool> coincident_views() const;

  /// Free views that refining moved by 0.4 radii or more to another one, and that share no more
  /// than one plane with any; where there are such, also those that it moved off all others with
  /// which they shared no more. Planes fit each other wherever the views belong; so do all views of
  /// what stands still before the sensor, as a wall. Pairs that normal maps determine share more:
  /// `pairs`, those of the refinement, tell.
  std::vector<bool> views_laid_on_planes(const std::vector<PairFit>& pairs) const;

  /// Whether the views fit each other as well at the given poses: they share as much, to 2 %,
  /// and neither the mean square of their distances nor its coherent part falls by more than 2 %
  /// and 10 %. Then what moved them are errors that neighbouring samples share. False where nothing
  /// overlaps.
  bool given_fit_as_well() const;

 private:
  std::vector<ViewPair> overlapping_pairs(const std::vector<RigidMotion>& poses) const;
  double reaches(const ViewPair& pair, const RigidMotion& of_a) const;

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>&given_, &refined_;
  const std::vector<ViewRole>& roles_;
  JudgeOptions judging_;
  std::vector<ViewPair> pairs_given_, pairs_refined_;  // Those that overlap at these poses.
};

}  // namespace relief::registration
