#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A relative pose of two views that their measurements allow.
struct PoseLink {
  std::size_t a = 0, b = 0;
  RigidMotion b_from_a = RigidMotion::Identity();
  PoseEvidence evidence;
  /// Only flat faces speak for it: they fit views that show other faces, too.
  bool planar_only = false;
  /// Flat faces dominate either view, and the samples off these meet (off_plane_samples.h).
  bool off_plane_confirmed = false;
  /// See lacks_shared_constraint().
  bool lacks_shared_constraint = false;

  /// Whether a motion between the two views is undetermined.
  bool degenerate() const { return evidence.degenerate || lacks_shared_constraint; }
};

/// With these numbers `relief_coarse_runs` places no view of 200 difficult scenes wrongly
/// (docs/results.md, Global registration).
struct ViewGroupOptions {
  VerificationThresholds limits;
  /// Links that share less count only when loops of three confirm them; in (0, 1].
  double lone_overlap = 0.3;
  /// How much larger the RMS of distances and of normals may be than those of the better links of
  /// the same project; > 1.
  double largest_excess = 1.5;
  /// The coherent RMS that is allowed to confirmed links [coherence_scale()]; at least that of
  /// `limits`, which holds for the others.
  double confirmed_coherent_rms = 0.2;
  /// Two ways of joining are told apart when the support of the weaker is below this part of that
  /// of the stronger; in (0, 1].
  double ambiguity = 0.5;
  JudgeOptions judge;
};

/// Two views that belong together, but in more ways than one.
struct AmbiguousPair {
  std::size_t a = 0, b = 0;
  double overlap = 0.0;  ///< Of the best way.
  /// Of the second best. Nothing where what the views share leaves the one way open: flat faces, or
  /// a degenerate direction.
  std::optional<double> second_overlap;
};

class JudgedPairs;

struct ViewGroups {
  /// For each view the smallest index in its group.
  std::vector<std::size_t> group;
  /// Into the frame of its group: that of the known views, else of the largest group that it
  /// started with, else of its first view.
  std::vector<RigidMotion> group_from_view;
  std::vector<PoseLink> joined;  ///< The links that were used, in order: a forest over the views.
  std::vector<AmbiguousPair> ambiguous;  ///< Between groups that stayed apart for it.
  /// For each view the link that shares most with a view of another group, for messages; nothing
  /// where the view has none. Empty but from register_globally().
  std::vector<std::optional<PoseLink>> best_rejected;
  /// For each view whether what stands clear of the plane that is most of it fits another view
  /// firmly, where the planes then deny the pose. Empty but from register_globally().
  std::vector<bool> denied_by_plane;

  bool all_in_one() const;
  /// Each view alone, in its own frame.
  static ViewGroups singles(std::size_t views);
};

/// Joins groups of views by links into larger ones. Doubtful links that no loop of three confirms
/// are left out. The others are tried in the order of the support they have: firm ones first, those
/// that close loops, and by overlap, as a maximum spanning forest. A link joins two groups only if
/// more of their pairs of views, each weighed by what it shares, agree with the poses that follow
/// than deny them, and only if no other link between the two groups explains the views nearly as
/// well. A pair denies a pose by how far it is beyond its limits: at worst where one view stands in
/// space that the other saw empty. The groups of `start` stay together; `known` views, in one of
/// them, stay where they are. `judged` remembers pairs of these surfaces from call to call.
ViewGroups join_views(const std::vector<ViewSurface>& surfaces, std::vector<PoseLink> links,
                      const ViewGroups& start, const std::vector<bool>& known,
                      const ViewGroupOptions& options, JudgedPairs& judged);

}  // namespace relief::registration
