#pragma once

#include "registration/global/pair_search.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "scan/units/unit_codec_private.h"

// How cereal writes the results of aligning. A structured binding names exactly the fields there
// are.

namespace relief::registration {

template <class Archive>
void serialize(Archive& archive, DegenerateDirection& direction) {
  auto& [motion, centre, description] = direction;
  archive(motion, centre, description);
}

template <class Archive>
void serialize(Archive& archive, PairFit& pair) {
  auto& [a, b, overlap, rms, correspondences, status, normal_maps, degenerate_directions] = pair;
  archive(a, b, overlap, rms, correspondences, status, normal_maps, degenerate_directions);
}

template <class Archive>
void serialize(Archive& archive, LoopClosure& loop) {
  auto& [views, radius, length, angle, length_std, angle_std] = loop;
  archive(views, radius, length, angle, length_std, angle_std);
}

template <class Archive>
void serialize(Archive& archive, ViewReport& view) {
  auto& [name, world_from_view, aligned, status, pose_covariance, pose_std, sensor_covariance,
         reason, kept_motions] = view;
  archive(name, world_from_view, aligned, status, pose_covariance, pose_std, sensor_covariance,
          reason, kept_motions);
}

template <class Archive>
void serialize(Archive& archive, SolverSummary& solve) {
  auto& [stage, termination, iterations, initial_cost, final_cost, message, seconds] = solve;
  archive(stage, termination, iterations, initial_cost, final_cost, message, seconds);
}

template <class Archive>
void serialize(Archive& archive, Alignment& alignment) {
  auto& [views, pairs, termination, iterations, last_motion, spacing, rms, solves, loops, notes,
         sensor_error] = alignment;
  archive(views, pairs, termination, iterations, last_motion, spacing, rms, solves, loops, notes,
          sensor_error);
}

template <class Archive>
void serialize(Archive& archive, CalibratedError& error) {
  auto& [kind, per_view, gain, gain_std, views_gain, views_gain_std, size, size_std] = error;
  archive(kind, per_view, gain, gain_std, views_gain, views_gain_std, size, size_std);
}

template <class Archive>
void serialize(Archive& archive, ViewCalibration& view) {
  auto& [sensor, coefficients, coefficient_std] = view;
  archive(sensor, coefficients, coefficient_std);
}

template <class Archive>
void serialize(Archive& archive, SensorCalibration& calibration) {
  auto& [errors, views, alignment, deviation_before, deviation_after, iterations, notes] =
      calibration;
  archive(errors, views, alignment, deviation_before, deviation_after, iterations, notes);
}

template <class Archive>
void serialize(Archive& archive, JointRefinement& refined) {
  auto& [world_from_view, termination, iterations, last_motion, rms, pairs, group, held,
         pose_covariance, pose_std, joint_covariance, kept_motions, solves, loops] = refined;
  static_cast<void>(joint_covariance);
  archive(world_from_view, termination, iterations, last_motion, rms, pairs, group, held,
          pose_covariance, pose_std, kept_motions, solves, loops);
}

template <class Archive>
void serialize(Archive& archive, PoseEvidence& evidence) {
  auto& [overlap, rms, coherent_rms, local_rms, normal_rms, in_front, free_space_violation, missing,
         missing_coverage, degenerate] = evidence;
  archive(overlap, rms, coherent_rms, local_rms, normal_rms, in_front, free_space_violation,
          missing, missing_coverage, degenerate);
}

template <class Archive>
void serialize(Archive& archive, PoseHypothesis& hypothesis) {
  auto& [b_from_a, evidence] = hypothesis;
  archive(b_from_a, evidence);
}

}  // namespace relief::registration
