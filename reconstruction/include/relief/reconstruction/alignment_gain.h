#pragma once

#include <cstddef>
#include <vector>

#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"

namespace relief::reconstruction {

/// Whether the poses of a second alignment are expected to be better than those of the first.
enum class GainVerdict {
  kGain,         ///< They are expected to be no worse.
  kNoGain,       ///< Their standard deviations are larger.
  kViewsLost,    ///< Some views no longer fit the others.
  kSolverFailed  ///< They were not refined to the end.
};

/// What aligning once more, on refined views, changed.
struct AlignmentGain {
  GainVerdict verdict = GainVerdict::kNoGain;
  double first_rms = 0.0, second_rms = 0.0;  ///< Of all point-to-plane distances [unit].
  /// Median over the free views of the standard deviation of a view's centre [unit].
  double first_pose_std = 0.0, second_pose_std = 0.0;
  double mean_motion = 0.0;  ///< Of the samples of the views aligned both times [unit].
  /// Views that only the first alignment placed. What refining left of their noise is less than the
  /// error of their calibration.
  std::size_t left_out = 0;

  /// Whether to take the second poses.
  bool kept() const { return verdict == GainVerdict::kGain; }
};

/// `views`: those that `first` aligned, in its order, with their ranges; `second` is their
/// alignment.
AlignmentGain compare_alignments(const registration::Alignment& first,
                                 const registration::Alignment& second,
                                 const std::vector<RangeView>& views);

}  // namespace relief::reconstruction
