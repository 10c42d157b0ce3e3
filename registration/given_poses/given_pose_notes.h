#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "registration/surface/view_surface.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"
#include "scan/views/pose_convention.h"

namespace relief::registration {

/// Errors of poses must be so many times smaller another way for it to be told, as for depth maps.
inline constexpr double kTellingRatio = 4.0;

/// A view that came with a pose and is aligned. Poses are world from view; the world may have moved
/// from one to the other.
struct GivenAndFound {
  std::string name;
  RigidMotion given = RigidMotion::Identity(), found = RigidMotion::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of its samples, view frame.
  bool refined = false;  ///< From the given pose, not found by shape; the world is the same.
  /// All its rays start at the origin of its frame, where the sensor stood.
  bool from_origin = false;
  std::optional<Eigen::Vector2d> focal_lengths = {};  ///< fx and fy of a pinhole [pixels].
  double spacing = 0.0;                               ///< Of its samples [unit].
};

/// The views with samples that came with a guess and that `found` has. The guesses are taken in
/// `convention`; `refined`: by view, as in GivenAndFound.
std::vector<GivenAndFound> given_and_found(const std::vector<RangeView>& views,
                                           const std::vector<ViewSurface>& surfaces,
                                           const PoseConvention& convention, const Alignment& found,
                                           const std::vector<bool>& refined);

/// How many times as far apart as given the sensors of views `from_origin` were found: 1.02 where
/// ranges are 2 % too long for the poses, or the poses in a smaller unit. Nothing for fewer than
/// four of them, and where it is no more than a thousandth, or not four times what single distances
/// scatter by.
std::optional<double> common_scale(const std::vector<GivenAndFound>& all);

/// 0 or 1 where the poses found are the given ones in a mirror that exchanges the sides of x or of
/// y in the frame of each view: four times nearer than without. Nothing for fewer than four views.
std::optional<int> mirrored_axis(const std::vector<GivenAndFound>& views);

/// Pairs of places in `views` that were exchanged: each view was found at the given pose of the
/// other, as where files have each other's names. So near, and four times nearer than to its own:
/// a sample spacing, or four times what views are typically off their given poses. Nothing unless
/// more than half of the views are at their own.
std::vector<std::pair<std::size_t, std::size_t>> exchanged_views(
    const std::vector<GivenAndFound>& views);

/// How far the centre of the samples is from where the given pose had it [unit].
double move_of(const GivenAndFound& view);

/// How far the centres of the refined views are from where the given poses had them, the median; 0
/// for fewer than two views [unit].
double median_move(const std::vector<GivenAndFound>& views);

/// For the user: how far refining moved the given poses, and what exchanged_views(),
/// common_scale(), mirrored_axis() and common_shift() tell. Of scale and shift the one that fits
/// better.
std::vector<std::string> notes_on_given_poses(const std::vector<GivenAndFound>& views);

}  // namespace relief::registration
