#pragma once

#include <cstddef>
#include <vector>

#include "registration/pairwise/correspondences.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Two views that see a common part of the surface; a < b.
struct ViewPair {
  std::size_t a = 0, b = 0;
  double overlap = 0.0;  ///< Fraction of samples that the other view saw, mean of both directions.
};

/// Of directed pair i of `pairs`: (a, b) at 2k, (b, a) at 2k + 1.
inline std::size_t source_of(const std::vector<ViewPair>& pairs, std::size_t i) {
  return i % 2 == 0 ? pairs[i / 2].a : pairs[i / 2].b;
}
inline std::size_t target_of(const std::vector<ViewPair>& pairs, std::size_t i) {
  return i % 2 == 0 ? pairs[i / 2].b : pairs[i / 2].a;
}

struct ViewGraphOptions {
  double max_distance = 0.0;  ///< Between corresponding points at the present poses [unit]; > 0.
  /// Between corresponding normals [deg]; keeps the two sides of thin sheets apart.
  double max_normal_angle_deg = 40.0;
  double min_overlap = 0.04;     ///< Pairs that share less are left out; in (0, 1].
  int min_correspondences = 50;  ///< So are pairs that share fewer samples than this.
  Association association = Association::kAuto;
};

/// The pairs of views with samples whose bounding spheres come as near to each other as `margin`
/// [unit] at the given poses, in lexicographic order, without their overlaps. The time grows with
/// the views and the pairs found, not with the square of the views.
std::vector<ViewPair> find_meeting_pairs(const std::vector<ViewSurface>& surfaces,
                                         const std::vector<RigidMotion>& world_from_view,
                                         double margin);

/// The pairs of views that overlap at the given poses, in lexicographic order. Each is judged by a
/// few hundred samples, and only where the bounding spheres meet.
std::vector<ViewPair> find_overlapping_pairs(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<RigidMotion>& world_from_view,
                                             const ViewGraphOptions& options);

/// Of pairs in lexicographic order those that are among the `per_view` largest overlaps of either
/// view, and what else keeps groups connected; in the same order.
std::vector<ViewPair> largest_overlaps(std::size_t views, const std::vector<ViewPair>& pairs,
                                       int per_view);

/// Connected groups of views: for each view the smallest index of a view that it is linked to,
/// directly or through others.
std::vector<std::size_t> connected_groups(std::size_t views, const std::vector<ViewPair>& pairs);

}  // namespace relief::registration
