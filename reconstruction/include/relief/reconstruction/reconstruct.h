#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/alignment_gain.h"
#include "relief/reconstruction/build_model.h"
#include "relief/reconstruction/cross_view_consistency.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/static_background.h"

namespace relief::reconstruction {

/// What becomes of ranges that several other views contradict, see weigh_by_consistency.
enum class ContradictedRanges {
  kCorrect,  ///< They count less; those far off move onto the surface of the other views.
  kWeigh,    ///< They count less.
  kKeep,     ///< Nothing: views are not compared.
};

struct ReconstructionOptions {
  /// Leave out what stands still in the camera's frame while the object turns.
  bool remove_background = true;
  registration::AlignOptions align;
  registration::CalibrationOptions calibration;
  ContradictedRanges contradicted = ContradictedRanges::kCorrect;
  hybrid::RefineOptions refine;
  ModelOptions model;
};

/// The second alignment, of refined views.
struct SecondAlignment {
  registration::Alignment alignment;
  AlignmentGain gain;
};

struct Reconstruction {
  /// The views of the model: refined, at their final poses, without those that were not aligned.
  std::vector<RangeView> views;
  Model model;

  StaticBackground background;                  ///< What was left out; `masks` by the views given.
  registration::SensorCalibration calibration;  ///< Of the views given.
  registration::Alignment first_alignment;      ///< Of the views given, as calibrated.
  std::vector<ViewConsistency> consistency;     ///< Of `views`; empty where it was not asked for.
  std::vector<hybrid::RefineSummary> refinements;   ///< Of `views`.
  std::optional<SecondAlignment> second_alignment;  ///< Nothing when no view could be refined.

  /// Whether all views given are aligned, all poses refined to the end, and no solve failed. When
  /// not, the model is that of the views that remain.
  bool complete() const;
};

/// Called as reconstruct() proceeds, from the thread that called it; each may be empty. An error
/// that one of them returns ends the reconstruction.
struct ReconstructionCallbacks {
  StageProgress progress;
  std::function<Result<void>(const registration::Alignment& first)> aligned;
  /// `views`: those given, corrected where errors were found.
  std::function<Result<void>(const registration::SensorCalibration& calibration,
                             const std::vector<RangeView>& views)>
      calibrated;
  std::function<Result<void>(const std::vector<ViewConsistency>& consistency,
                             const std::vector<RangeView>& views)>
      compared;
  std::function<Result<void>(const std::vector<hybrid::RefineSummary>& refinements,
                             const std::vector<RangeView>& views)>
      refined;
  std::function<Result<void>(const SecondAlignment& second)> aligned_again;
  /// The views with their final ranges, normals and poses, before they are merged.
  std::function<Result<void>(const std::vector<RangeView>& views)> views_finished;
};

/// The whole way from range views to one closed model: removes the static background, aligns the
/// views, corrects what the calibration of their sensors has wrong, lowers the confidence of ranges
/// that other views contradict, refines each view with its normals, aligns them again, and builds
/// the model. The poses of the second alignment are taken only when they are expected to be no
/// worse. Views that cannot be aligned are left out; views that cannot be refined take part as
/// measured. Positions are in the unit of the views, the model in their world frame. Its stages are
/// units of work, each view refined one of its own. The memory of the context is that of the whole
/// process, the views among it. Fewer views are then refined at once, and merging works in files of
/// `temporary_folder`; the result is the same. Its progress is told of all stages together.
///
/// Errors: those of registration::align_views, hybrid::refine_views and build_model; kUnsolvable
/// when no view can be aligned, or, before work starts, when the memory does not suffice to align
/// and refine the views; kInterrupted.
Result<Reconstruction> reconstruct(std::vector<RangeView> views,
                                   const ReconstructionOptions& options = {},
                                   const Context& context = {},
                                   const ReconstructionCallbacks& callbacks = {});

}  // namespace relief::reconstruction
