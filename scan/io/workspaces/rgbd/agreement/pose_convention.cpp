#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/LU>

namespace relief {

namespace {

// Two conventions are told apart where one agrees so much better. Those that give the same poses
// relative to each other agree alike to rounding.
constexpr double kBetter = 1.5;
constexpr double kRounding = 1e-9;

// Of the pixels that meet as the poses are given, how many must meet in another convention: few
// pixels may agree by chance.
constexpr double kEnoughMeet = 0.5;

// All signed permutations of the axes, the identity first, those that keep the hand before the
// others.
std::vector<Eigen::Matrix3d> all_axes() {
  std::vector<Eigen::Matrix3d> all;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i)
        axes(i, order[static_cast<std::size_t>(i)]) = (signs >> i) % 2 == 0 ? 1.0 : -1.0;
      all.push_back(axes);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  std::stable_partition(all.begin(), all.end(),
                        [](const Eigen::Matrix3d& axes) { return axes.determinant() > 0.0; });
  return all;
}

std::string note_text(PoseConvention convention, const Eigen::Matrix3d& stored_axes,
                      const std::optional<Disagreement>& as_given, double as_read) {
  const bool mirrored = convention.axes.determinant() < 0.0;
  if (!convention.view_from_world) convention.axes = stored_axes * convention.axes;
  char agreement[160];
  std::snprintf(agreement, sizeof agreement, ": so the depth maps agree to %.2g %% of the depth, ",
                100.0 * as_read);
  std::string text = "the poses are taken as " + convention.describe() + agreement;
  if (as_given) {
    std::snprintf(agreement, sizeof agreement, "as given to %.2g %%", 100.0 * as_given->median);
    text += agreement;
  } else {
    text += "as given they do not meet";
  }
  if (mirrored) text += "; the images may be mirrored instead, and the model then is";
  return text;
}

// The reading that agrees far better than the first, and better than all that are not the same.
// Where views do not meet in the first, it must agree as depth cameras do.
std::optional<std::size_t> far_better(const std::vector<std::optional<Disagreement>>& found) {
  std::optional<std::size_t> best;
  const auto least = static_cast<std::size_t>(
      found[0] ? kEnoughMeet * static_cast<double>(found[0]->pixels) : 0.0);
  const auto is_candidate = [&](std::size_t k) { return found[k] && found[k]->pixels >= least; };
  for (std::size_t k = 1; k < found.size(); ++k)
    if (is_candidate(k) && (!best || found[k]->median < (1.0 - kRounding) * found[*best]->median))
      best = k;
  if (!best) return std::nullopt;
  const double median = found[*best]->median;
  if (found[0] ? !(found[0]->median > kFarBetter * median) : median > kCameraError)
    return std::nullopt;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (is_candidate(k) && found[k]->median < kBetter * median &&
        found[k]->median > (1.0 + kRounding) * median)
      return std::nullopt;
  return best;
}

struct BestReading {
  PoseConvention convention;
  double median = 0.0;  // Of the disagreement.
  std::optional<Disagreement> as_given;
};

// Of the conventions with the rotations as they are read, or of the others; see far_better().
std::optional<BestReading> best_reading(const ProjectSpec& project, const ComparedDepths& compared,
                                        bool rotations_as_read) {
  std::vector<DepthReading> readings(1);  // As given.
  for (const PoseConvention& convention : possible_conventions()) {
    const bool as_read = convention.rotation == StoredRotation::kAsRead;
    if (!convention.as_given() && as_read == rotations_as_read)
      readings.push_back({.poses = convention});
  }
  const auto found = compared.disagreements(project, readings);
  const auto best = far_better(found);
  if (!best) return std::nullopt;
  return BestReading{readings[*best].poses, found[*best]->median, found[0]};
}

}  // namespace

std::vector<PoseConvention> possible_conventions() {
  const auto axes_first_to_last = all_axes();
  const std::vector<Eigen::Matrix3d> usual = {Eigen::Matrix3d::Identity(), opengl_axes()};
  std::vector<PoseConvention> conventions;
  for (const double unit : {1.0, 0.001, 0.01, 100.0, 1000.0})
    for (const bool view_from_world : {false, true})
      for (const Eigen::Matrix3d& axes : unit == 1.0 ? axes_first_to_last : usual)
        conventions.push_back({unit, view_from_world, axes});
  for (const auto rotation : {StoredRotation::kInverse, StoredRotation::kQuaternionWFirst})
    for (const bool view_from_world : {false, true})
      for (const Eigen::Matrix3d& axes : usual)
        conventions.push_back({1.0, view_from_world, axes, rotation});
  return conventions;
}

void take_pose_convention(ProjectSpec& project, const ComparedDepths& compared,
                          const Eigen::Matrix3d& stored_axes) {
  // Where cameras hardly turn, other rotations agree as well as the right convention: they must
  // agree far better than any with the rotations as read.
  auto best = best_reading(project, compared, true);
  if (auto other = best_reading(project, compared, false);
      other && (!best || best->median > kFarBetter * other->median))
    best = std::move(other);
  if (!best) return;
  const PoseConvention& taken = best->convention;
  for (ViewSpec& view : project.views)
    if (view.pose != PoseKind::kAbsent)
      view.world_from_view = taken.world_from_view(view.world_from_view);
  project.notes.push_back(note_text(taken, stored_axes, best->as_given, best->median));
}

void note_disagreement_at_poses(ProjectSpec& project, const ComparedDepths& compared) {
  const auto found = compared.disagreements(project, {{.along_ray = has_ray_lengths(project)}})[0];
  if (!found || found->median < kBeyondCameraError) return;
  char note[240];
  std::snprintf(note, sizeof note,
                "the depth maps disagree at their poses by %.2g %% of the depth, in any convention "
                "of poses: check the poses, the intrinsics, and what the depths are",
                100.0 * found->median);
  project.notes.emplace_back(note);
}

}  // namespace relief
