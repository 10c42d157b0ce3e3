#pragma once

#include <cstddef>
#include <vector>

namespace relief::registration {

/// How far the motions of the pairs of a cycle of views, each found by that pair alone and composed
/// around the cycle, miss the identity (R16). Motions that a pair alone does not determine are
/// those of the joint solution.
struct LoopClosure {
  /// In the order of the walk: a pair joins each to the next one, and the last to the first.
  std::vector<std::size_t> views;
  double radius = 0.0;  ///< Mean radius of the views [unit].
  /// Root mean square displacement, by the motion around the cycle, of the points at `radius` from
  /// the mean centre of the views [unit].
  double length = 0.0;
  double angle = 0.0;  ///< Of the rotation of that motion [rad].
  /// What noise makes of both, root mean square (R17). Errors of calibration are no part of it.
  double length_std = 0.0, angle_std = 0.0;

  /// `length` over `length_std`: about 1 where noise explains the loop; 0 if that is unknown.
  double ratio() const { return length_std > 0.0 ? length / length_std : 0.0; }
};

}  // namespace relief::registration
