#pragma once

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/shared_surface.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What two views' own measurements say of a relative pose.
struct PoseEvidence {
  double overlap = 0.0;  ///< Fraction of samples that the other view saw, mean of both directions.
  double rms = 0.0;      ///< Of the point-to-plane distances [unit].
  /// The part of it that neighbouring samples share [unit]: noise is not in it, not even noise that
  /// is alike over a few pixels; the systematic misfit of a wrong pose is.
  double coherent_rms = 0.0;
  /// The coherent part with close neighbours included, which share noise where the sensor smooths
  /// its images [unit].
  double local_rms = 0.0;
  double normal_rms = 0.0;  ///< Of the differences between corresponding unit normals.
  /// Fraction of a view's samples that would have hidden from the other sensor what it measured
  /// (Huber and Hebert 2003); the larger of both directions. 0 where neither sensor has a
  /// projection.
  double in_front = 0.0;
  /// The same as a fraction of the samples that overlap or lie in front.
  double free_space_violation = 0.0;
  /// Fraction of a view's samples that face the other sensor, which measured nothing there nor
  /// nearby; the larger of both directions. 0 where neither sensor has a projection.
  double missing = 0.0;
  /// The same as a fraction of the samples that overlap or are missing.
  double missing_coverage = 0.0;
  /// Whether the shared surface leaves a rigid motion undetermined (equation R5).
  bool degenerate = false;
};

struct JudgeOptions {
  Association association = Association::kAuto;
  /// Samples of each view that are looked at; > 0. Bounds the time: an overlap of 0.15 is told to
  /// 0.01.
  int probes = 1500;
  /// Between corresponding normals [deg]; keeps the two sides of thin sheets apart.
  double max_normal_angle_deg = 40.0;
  /// Standard deviation of the distance between two views at least [unit]: for errors that the
  /// noise of single samples does not show.
  double min_stddev = 0.0;
};

/// Pairs of views that share less than this fraction of their samples say little of their fit: it
/// is 25 of the 500 samples of judge_free_space(), five deviations from none.
inline constexpr double kCountingOverlap = 0.05;

/// A calibration is made to the noise of its sensor: its errors are hardly more than twice that.
/// Matters where that is more than five times VerificationThresholds::max_coherent_rms.
inline constexpr double kWarpDeviations = 2.0;

/// Samples of either view for rough_agreement(); bounds the time. A fraction of 0.08 is told to
/// 0.022.
inline constexpr int kRoughProbes = 150;

/// What a pose must show to be believed. With these numbers `relief_coarse_runs` places no view of
/// 200 difficult scenes wrongly (docs/results.md, Global registration).
struct VerificationThresholds {
  double min_overlap = 0.15;  ///< In (0, 1].
  /// Largest RMS in units of largest_plausible_rms(): its noise is white, that of real scanners is
  /// not.
  double max_rms = 2.2;
  /// Largest RMS of the differences between unit normals: 60 degrees.
  double max_normal_rms = 1.0;
  /// Largest coherent RMS [coherence_scale(): sample spacings, or more]. Calibration errors of real
  /// scanners reach 0.15, wrong poses hardly ever stay below 0.2.
  double max_coherent_rms = 0.2;
  /// Largest contradiction, in [0, 1]. At true poses there is none, at wrong ones rarely less than
  /// a twentieth.
  double max_free_space_violation = 0.02;
  /// Largest absence of a pair that is believed alone, in [0, 1]. At true poses sensors lose some
  /// of what they face, in shadows and dark places; at wrong ones, above all of plain surfaces,
  /// they should mostly have seen much more.
  double max_missing_coverage = 0.12;
};

/// Whether some samples of one view stand where the other saw through: by more than stray samples.
bool violates_free_space(const PoseEvidence& evidence, const VerificationThresholds& limits = {});

/// Whether a sensor should have seen more of the other view than shadows and losses explain. This
/// alone does not refute a pose, but it takes more than one such pair to believe it.
bool misses_coverage(const PoseEvidence& evidence, const VerificationThresholds& limits = {});

/// The RMS of the evidence in units of what noise and sampling of the two views explain.
double relative_rms(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b);

/// What coherent misfits are measured in [unit]: the coarser sample spacing, at least a hundredth
/// of the smaller radius. Wrong poses misfit in proportion to the views, however fine their
/// samples; so do errors of a calibration.
double coherence_scale(const ViewSurface& a, const ViewSurface& b);

/// The coherent RMS of the evidence [coherence_scale()], less what the rounding of the ranges
/// makes: all samples of a terrace are rounded alike.
double relative_coherent_rms(const PoseEvidence& evidence, const ViewSurface& a,
                             const ViewSurface& b);

/// Whether close neighbours agree on a misfit. In views that are coarse against what they show that
/// is where wrong poses show most; it may be noise alike over a few pixels too.
bool misfits_locally(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                     const VerificationThresholds& limits = {});

/// Whether the evidence supports the relative pose of the two views. Degenerate directions and
/// missing coverage play no part.
bool plausible(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
               const VerificationThresholds& limits = {});

/// The largest of free-space violation, RMS, RMS of the normals and coherent RMS, each in units of
/// its limit: above 1 where the evidence is not plausible for any of them.
double largest_ratio(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                     const VerificationThresholds& limits);

/// Judges a pose that is thought to be right to a few sample spacings.
PoseEvidence judge_pose(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                        const JudgeOptions& options = {});

/// The overlap, the free-space violation and the missing coverage alone, from fewer samples: all
/// else of the evidence stays zero. Takes a tenth of the time of judge_pose().
PoseEvidence judge_free_space(const ViewSurface& a, const ViewSurface& b,
                              const RigidMotion& b_from_a, const JudgeOptions& options = {});

/// What judge_pose() finds the two views to share, in the frame of b.
SharedSurface shared_surface(const ViewSurface& a, const ViewSurface& b,
                             const RigidMotion& b_from_a, const JudgeOptions& options);

/// Whether nine tenths of the samples that two views share are on one plane, as far as errors
/// explain: then they fit at all poses that move the plane in itself.
bool shares_one_plane(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                      const JudgeOptions& options = {});

/// A pose that is at best right to `reach` [unit] in a number that can be had many thousand times a
/// second: the fraction of `probes` samples of each view that lie within `reach` of the other's
/// surface with a similar normal, less twice the fraction that lie farther in front of it.
double rough_agreement(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                       double reach, int probes);

}  // namespace relief::registration
