#pragma once

namespace relief::registration {

enum class NormalSource {
  kGeometric,  ///< Of the measured surface, smoothed: right whatever the normal maps are.
  /// The view's own where it has them: for refined views. Their samples share errors, and count by
  /// their confidence alone.
  kMeasured,
};

struct ViewSurfaceOptions {
  NormalSource normals = NormalSource::kGeometric;
  /// Half width [pixels] of the window of geometric normals. 0: the smallest whose normals are good
  /// to two degrees at the view's noise.
  int normal_radius = 0;
  /// Samples nearer than this [pixels] to a silhouette, an occlusion edge or the border of the grid
  /// are not used to search and to judge by: they are the least accurate, and there overlap ends.
  /// With 1 normals near them are too uncertain to judge poses by. >= 1.
  int boundary_margin = 2;
  /// The same for the last steps of refining poses, which want all that is of any use: 1 is
  /// measured to be better than 2 (docs/results.md, Samples near boundaries). >= 1; no effect from
  /// boundary_margin up.
  int final_margin = 1;
  /// Keep the view's normal map, freed of its smooth bias, as a signal to align by.
  bool normal_signal = true;
  /// Build the nearest-neighbour index even where the camera can project.
  bool neighbour_index = false;
};

enum class Association {
  kAuto,        ///< Projective where the target's camera can project, else nearest.
  kProjective,  ///< The target's surface at the pixel that sees the point: constant time.
  kNearest,     ///< The closest point of the target's surface.
};

/// What to make of the poses that views come with. Known poses (PoseKind::kKnown) always stay.
enum class GivenPoses {
  kCheck,   ///< Evidence: refined from where they are, kept unless the other views refute them.
  kTrust,   ///< Refined from where they are, and kept whatever the other views say.
  kIgnore,  ///< Not looked at: all poses are found by shape.
};

struct StartingPoseOptions {
  GivenPoses given = GivenPoses::kCheck;
  /// Whether to look by shape for poses that are not given, or not confirmed.
  bool search = true;
  Association association = Association::kAuto;
  /// Whether all given poses stay to the bit where refining finds none that fit better (see
  /// docs/registration.md, Given poses). Poses that the views gave need not.
  bool keep_given = true;
  /// Two views are linked by shape when they share at least this fraction of their samples; in (0,
  /// 1]. With it and the next `relief_coarse_runs` places no view wrongly (docs/results.md, Global
  /// registration).
  double min_overlap = 0.15;
  /// At most this fraction of the samples that can be compared may lie in front of what the other
  /// view saw; in [0, 1].
  double max_free_space_violation = 0.02;
};

struct JointRefinementOptions {
  Association association = Association::kAuto;
  /// Correspondences per direction of a pair at the finest level; >= 6. Bounds the time; the last
  /// steps use final_samples.
  int correspondences = 1500;
  /// Levels from coarse (few correspondences, wide search) to fine; >= 1.
  int levels = 3;
  /// How far apart corresponding points may be at the starting poses [unit]. 0: a fifth of the
  /// median radius of the views.
  double search_distance = 0.0;
  /// Samples per direction of a pair, at most, of the last steps, which determine the precision;
  /// 0: all.
  int final_samples = 0;
  /// Between corresponding normals [deg]; keeps the two sides of thin sheets apart.
  double max_normal_angle_deg = 40.0;
  double min_overlap = 0.04;     ///< Pairs of views that share less are not used; (0, 1].
  int min_correspondences = 50;  ///< So are pairs that share fewer samples; >= 6.
  /// Poses stand still when renewing the correspondences moves no sample by more than this [sample
  /// spacings]. Poses err by about as much (docs/results.md, Poses against the least error
  /// possible).
  double tolerance = 0.01;
  int max_iterations = 40;  ///< Renewals of the correspondences, per level; bounds the time.
};

struct AlignOptions {
  ViewSurfaceOptions surface;
  StartingPoseOptions starting_poses;
  JointRefinementOptions refinement;
};

}  // namespace relief::registration
