#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What is known of the poses before any is looked for by shape.
struct CheckedPoses {
  /// Given poses, refined; nothing for views without one and for views whose pose was refuted.
  std::vector<std::optional<RigidMotion>> world_from_view;
  /// For each view the smallest index of a view that confirms its pose, directly or through others.
  std::vector<std::size_t> group;
  std::vector<bool> known;    ///< Exact poses, which do not move.
  std::vector<bool> refuted;  ///< Whether a given pose was refuted.
  /// Refuted poses, refined, at which a part of the view fits: the rest may have moved between the
  /// scans, as the arm of a robot. They hold where no pose is found by shape.
  std::vector<std::optional<RigidMotion>> fits_in_part;
  /// Given poses that stay to the bit, as refining found none that fit better (kept_poses.h).
  std::vector<bool> kept;
  /// Of these, those that refining led to where one plane is all they share with others
  /// (GivenAndRefined::views_laid_on_planes()). Nothing tells their poses, and they tell none.
  std::vector<bool> laid_on_plane;
};

}  // namespace relief::registration
