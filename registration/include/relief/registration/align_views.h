#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "relief/registration/align_options.h"
#include "relief/registration/loop_closure.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

enum class RefinementTermination {
  kConverged,
  kIterationLimit,  ///< Poses still moved by more than the tolerance.
  kNoOverlap,       ///< No two views overlap at the starting poses: nothing was done.
  /// The equations of the poses are not finite, as from infinite confidences: the poses are the
  /// last ones before that, and neither pairs nor covariances are known.
  kSolverFailed,
};

/// What is known of a view's pose after alignment.
enum class PoseStatus {
  kVerified,    ///< Other views confirm it.
  kUnverified,  ///< It is the given pose, refined where views overlap it; nothing confirms it.
  kLeftOut,     ///< None is known, the given one is refuted, or the view is of another unit.
};

/// What became of one view.
struct ViewReport {
  std::string name;
  RigidMotion world_from_view = RigidMotion::Identity();
  /// Whether the pose is in one frame with the main group of views: verified or not.
  bool aligned = false;
  PoseStatus status = PoseStatus::kLeftOut;
  /// Covariance of the pose as tangent (rotation [rad], translation [unit]) about the view's centre
  /// in world axes, relative to the held view (R12), with what errors of the sensors explain (R19),
  /// and the roots of its diagonal.
  Matrix6d pose_covariance = Matrix6d::Zero();
  RigidTangent pose_std = RigidTangent::Zero();
  /// The part of `pose_covariance` that errors of the sensors explain; zero where none show.
  Matrix6d sensor_covariance = Matrix6d::Zero();
  std::string reason;  ///< Why it is not verified; empty when it is.
  /// Motions (world frame) along which the view keeps the pose that it started from: nothing but
  /// noise tells anything about them.
  std::vector<DegenerateDirection> kept_motions;
};

enum class SolverTermination {
  kConverged,
  kIterationLimit,  ///< Usual where correspondences are renewed: few steps are enough then.
  kFailed,          ///< The equations are not finite, or cannot be solved: no pose was moved.
};

/// What a minimisation is about.
enum class SolverStage {
  kJoint,        ///< Correspondences of all pairs, renewed after each solve (R3).
  kPoseGraph,    ///< The quadratic sum over all samples of all pairs (R11).
  kCalibration,  ///< Poses and errors of the sensors together (C2).
};

/// One minimisation over all poses, as the solver sums it up.
struct SolverSummary {
  SolverStage stage = SolverStage::kJoint;
  SolverTermination termination = SolverTermination::kFailed;
  int iterations = 0;  ///< Steps of Levenberg-Marquardt, also those that were rejected.
  /// Half the sum of all losses (R3) before and after; after a pose graph step, as it expects.
  double initial_cost = 0.0, final_cost = 0.0;
  std::string message;  ///< Why it ended, in the solver's words.
  double seconds = 0.0;
};

struct Alignment {
  std::vector<ViewReport> views;  ///< In the order given.
  std::vector<PairFit> pairs;     ///< Of all overlapping pairs.
  RefinementTermination termination = RefinementTermination::kNoOverlap;
  int iterations = 0;                 ///< Renewals of the correspondences.
  double last_motion = 0.0;           ///< Largest motion of a sample by the last step [unit].
  double spacing = 0.0;               ///< Between samples of a typical view [unit].
  double rms = 0.0;                   ///< Of all point-to-plane distances [unit].
  std::vector<SolverSummary> solves;  ///< Of the refinement that gave the poses, in their order.
  std::vector<LoopClosure> loops;     ///< Of cycles of pairs, the least explained first.
  std::vector<std::string> notes;     ///< What the user should know, one line each.
  /// In words, the error of the sensors that explains most of what views disagree by (R19); empty
  /// where none shows.
  std::string sensor_error;

  /// Whether all views are in one frame.
  bool complete() const;
  /// Whether another step would move the views by no more than a fifth of what their poses err by
  /// anyway, as `pose_std` has it: that adds two percent to their errors.
  bool stands_still() const;
  /// Whether the poses were refined to the end.
  bool solved() const { return termination != RefinementTermination::kSolverFailed; }
  std::vector<RigidMotion> world_from_view() const;
};

/// Brings range views into one frame. Given poses are refined together, then verified; views whose
/// pose nothing confirms are searched for by shape. A given pose that no view refutes is kept even
/// then, with the status kUnverified. Known poses are kept to the bit; else the first view of the
/// largest group of overlapping views stays where it is. Views without a pose that fit none are
/// reported, never forced. Pairs searched and poses refined together are units of work. Errors:
/// kBadInput for no views or impossible options, kInterrupted.
Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options = {},
                              const Context& context = {});

/// `converged`, `iteration limit`, `no overlap` or `solver failed`.
std::string_view to_string(RefinementTermination termination);

/// `verified`, `unverified` or `left out`.
std::string_view to_string(PoseStatus status);

/// `converged`, `iteration limit` or `failed`.
std::string_view to_string(SolverTermination termination);

/// `joint`, `pose graph` or `calibration`.
std::string_view to_string(SolverStage stage);

/// Gives `views`, those that were aligned and in the same order, the poses found. An aligned view
/// that had no pose has a guess from then on, so that merging takes it; a known pose stays known.
/// Views that were not aligned have no guess from then on: it is refuted, or of another frame.
void apply_alignment(const Alignment& alignment, std::vector<RangeView>& views);

}  // namespace relief::registration
