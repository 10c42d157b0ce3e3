#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/model/error_model.h"
#include "registration/pairwise/correspondences.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/grid/range_noise.h"

namespace relief::registration {

/// How correspondences between such surfaces are searched for once their poses are good.
CorrespondenceOptions finest_search(const std::vector<ViewSurface>& surfaces,
                                    const JointRefinementOptions& refinement);

/// The samples of `measured` that the surfaces are of, at such poses, as sum_pairs() takes them.
/// All but the last two outlive the result. Views without pairs have no nearby ranges.
CalibratedViews calibrated_views(const std::vector<RangeView>& given,
                                 const std::vector<RangeView>& measured,
                                 const std::vector<ViewSurface>& surfaces, const Sensors& sensors,
                                 const std::vector<RigidMotion>& world_from_view,
                                 const std::vector<ViewPair>& pairs);

/// finest_search() with `samples` of the source, and patches as large as the clusters of (R12).
CalibrationSumOptions sum_options(const std::vector<ViewSurface>& surfaces,
                                  const JointRefinementOptions& refinement, std::size_t samples);

/// The views with the errors that are known so far taken out, and their surfaces.
class CorrectedViews {
 public:
  /// Told the part of the surfaces that is made; false ends it.
  using Reporting = std::function<bool(double part)>;

  /// `given` and `sensors` outlive this.
  CorrectedViews(const std::vector<RangeView>& given, const Sensors& sensors, AlignOptions align)
      : given_(given), sensors_(sensors), align_(std::move(align)), noise_(given.size()) {}

  /// Takes the errors of `model` out of the views. Without normals the surfaces have no signal to
  /// align normal maps by. Error: kInterrupted.
  Result<void> correct(const ErrorModel& model, bool with_normals, const Reporting& report);

  /// What the correspondences of the pairs say at such poses, from `samples` of the source at most.
  std::vector<PairSums> sum(const std::vector<RigidMotion>& world_from_view,
                            const std::vector<ViewPair>& pairs, std::size_t samples);

  const std::vector<RangeView>& given() const { return given_; }
  /// Without normals, unless the last correct() was with them.
  const std::vector<RangeView>& views() const { return views_; }
  const std::vector<ViewSurface>& surfaces() const { return surfaces_; }
  const AlignOptions& align() const { return align_; }
  /// Of the tangents of the last sums; world frame.
  const Eigen::Vector3d& centre() const { return calibrated_.centre; }

 private:
  const std::vector<RangeView>& given_;
  const Sensors& sensors_;
  const AlignOptions align_;
  std::vector<std::optional<RangeNoise>> noise_;  // Of the views given, once it is known.
  std::vector<RangeView> views_;
  std::vector<ViewSurface> surfaces_;
  CalibratedViews calibrated_;
};

}  // namespace relief::registration
