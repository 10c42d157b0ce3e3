#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "registration/correspondences.h"
#include "registration/pair_fit.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/result.h"
#include "scan/rigid_motion.h"

namespace relief {

struct JointRefinementOptions {
  Association association = Association::kAuto;
  /// Correspondences per direction of a pair at the finest level; >= 6.
  int correspondences = 1500;
  /// Levels from coarse (few correspondences, wide search) to fine; >= 1.
  int levels = 3;
  /// How far apart corresponding points may be at the starting poses [unit]. 0: a fifth of the
  /// median radius of the views.
  double search_distance = 0.0;
  /// Samples per direction of a pair, at most, of the last steps, which determine the precision;
  /// 0: all.
  int final_samples = 0;
  double max_normal_angle_deg = 40.0;  ///< Between corresponding normals.
  double min_overlap = 0.04;           ///< Pairs of views that share less are not used; (0, 1].
  int min_correspondences = 50;        ///< So are pairs that share fewer samples; >= 6.
  /// Poses stand still when renewing the correspondences moves no sample by more than this [sample
  /// spacings].
  double tolerance = 0.01;
  int max_iterations = 40;  ///< Renewals of the correspondences, per level.
  int threads = 0;          ///< 0: one per core. Never changes the result.
};

enum class RefinementTermination {
  kConverged,
  kIterationLimit,  ///< Poses still moved by more than the tolerance.
  kNoOverlap,       ///< No two views overlap at the starting poses: nothing was done.
  /// The equations of the poses are not finite, as from infinite confidences: the poses are the
  /// last ones before that, and neither pairs nor covariances are known.
  kSolverFailed,
};

struct JointRefinement {
  std::vector<RigidMotion> world_from_view;
  RefinementTermination termination = RefinementTermination::kNoOverlap;
  int iterations = 0;      ///< Renewals of the correspondences over all levels.
  double last_motion = 0;  ///< Largest motion of a sample by the last one [unit].
  double rms = 0.0;        ///< Over all correspondences [unit].
  std::vector<PairFit> pairs;
  /// For each view the smallest index of a view that pairs link it to. Groups do not see each
  /// other: within each, poses are relative to its held view.
  std::vector<std::size_t> group;
  /// Views that did not move: the fixed ones and, in groups without any, the first.
  std::vector<bool> held;
  /// Covariance of all poses (6V x 6V), tangents (rotation [rad], translation [unit]) about each
  /// view's centre in world axes; zero for held views. See PoseNetwork::covariance().
  Eigen::MatrixXd pose_covariance;
  std::vector<RigidTangent> pose_std;  ///< The roots of its diagonal.
};

/// What the refinement may do with a view.
enum class ViewRole {
  kFree,      ///< Its pose is refined.
  kFixed,     ///< Its pose stays, to the bit; others are aligned to it.
  kExcluded,  ///< It has no meaningful pose: it pairs with none and stays.
};

/// Refines all poses at once: minimises the robust point-to-plane distances of all overlapping
/// pairs, both ways (R3), and renews the correspondences until the poses stand still. The only
/// error is kInterrupted.
Result<JointRefinement> refine_jointly(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<ViewRole>& roles,
                                       const JointRefinementOptions& options = {},
                                       const Progress& progress = {});

/// `converged`, `iteration limit`, `no overlap` or `solver failed`.
std::string_view to_string(RefinementTermination termination);

}  // namespace relief
