#include "relief/evaluation/pose_errors.h"

#include <algorithm>
#include <cmath>

#include "scan/evaluation/base/angles.h"

namespace relief::evaluation {

namespace {

// A view's samples where the truth and where the result puts them.
struct PosedView {
  std::string name;
  RigidMotion true_pose, result_pose;
  Eigen::Matrix3Xd in_truth, in_result;
};

Eigen::Matrix3Xd some_samples(const RangeView& view, std::size_t most) {
  const std::size_t stride = view.sample_count() / std::max<std::size_t>(most, 1) + 1;
  Eigen::Matrix3Xd samples(3, static_cast<Eigen::Index>(view.sample_count() / stride + 1));
  Eigen::Index kept = 0;
  std::size_t seen = 0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v) && seen++ % stride == 0) samples.col(kept++) = view.point(u, v);
  return samples.leftCols(kept);
}

Result<std::vector<PosedView>> pose_views(const ScanProject& result, const ScanProject& truth,
                                          std::size_t samples_per_view) {
  std::vector<PosedView> views;
  for (const RangeView& view : result.views) {
    if (view.pose == PoseKind::kAbsent) continue;
    const RangeView* true_view = find_view(truth, view.name);
    if (!true_view || true_view->pose == PoseKind::kAbsent || true_view->sample_count() == 0)
      return Error{ErrorKind::kBadInput, "the truth has no view with samples and a pose named " +
                                             view.name + ", so its pose cannot be judged"};
    const Eigen::Matrix3Xd samples = some_samples(*true_view, samples_per_view);
    views.push_back({view.name, true_view->world_from_view, view.world_from_view,
                     true_view->world_from_view * samples, view.world_from_view * samples});
  }
  if (views.empty())
    return Error{ErrorKind::kUnsolvable, "the result has no view with a pose to compare"};
  return views;
}

double mean_displacement(const PosedView& view, const RigidMotion& truth_from_result) {
  return (truth_from_result * view.in_result - view.in_truth).colwise().norm().mean();
}

// Equation (E4). Every view counts alike, times its weight.
RigidMotion weighted_common_motion(const std::vector<PosedView>& views,
                                   const std::vector<double>& view_weights) {
  Eigen::Index count = 0;
  for (const PosedView& view : views) count += view.in_truth.cols();
  Eigen::Matrix3Xd source(3, count), target(3, count);
  Eigen::VectorXd weights(count);
  Eigen::Index begin = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Index size = views[i].in_truth.cols();
    source.middleCols(begin, size) = views[i].in_result;
    target.middleCols(begin, size) = views[i].in_truth;
    weights.segment(begin, size).setConstant(view_weights[i] / static_cast<double>(size));
    begin += size;
  }
  return best_rigid_motion(source, target, weights);
}

// With `robust`, reweighted least squares for the sum over views of their displacements.
RigidMotion common_motion(const std::vector<PosedView>& views, bool robust) {
  std::vector<double> weights(views.size(), 1.0);
  RigidMotion motion = weighted_common_motion(views, weights);
  // Bounds the time: a round costs one fit. Converges linearly, as Weiszfeld's iteration (1937) for
  // the median of points.
  constexpr int kRounds = 50;
  for (int round = 0; robust && round < kRounds; ++round) {
    double largest = 0.0;
    for (std::size_t i = 0; i < views.size(); ++i) {
      weights[i] = mean_displacement(views[i], motion);
      largest = std::max(largest, weights[i]);
    }
    if (largest == 0.0) break;
    // The floor keeps a view that fits exactly from deciding alone.
    for (double& weight : weights) weight = 1.0 / std::max(weight, 1e-6 * largest);
    motion = weighted_common_motion(views, weights);
  }
  return motion;
}

// Of the motion (E5).
PoseError pose_error(const PosedView& view, const RigidMotion& truth_from_result) {
  const Eigen::Matrix3Xd placed = truth_from_result * view.in_result;
  const Eigen::Matrix3Xd displacement = placed - view.in_truth;
  PoseError error;
  error.name = view.name;
  error.rotation_deg =
      degrees(rotation_angle(truth_from_result * view.result_pose * view.true_pose.inverse()));
  error.translation = displacement.rowwise().mean().norm();
  error.mean_displacement = displacement.colwise().norm().mean();
  error.rms_displacement = std::sqrt(displacement.colwise().squaredNorm().mean());
  return error;
}

void summarize_views(PoseErrorReport& report) {
  const double share = 1.0 / static_cast<double>(report.views.size());
  double squares = 0.0;
  for (const PoseError& view : report.views) {
    report.mean_rotation_deg += share * view.rotation_deg;
    report.mean_translation += share * view.translation;
    report.mean_displacement += share * view.mean_displacement;
    squares += share * view.rms_displacement * view.rms_displacement;
    report.max_rotation_deg = std::max(report.max_rotation_deg, view.rotation_deg);
    report.max_translation = std::max(report.max_translation, view.translation);
    report.max_displacement = std::max(report.max_displacement, view.mean_displacement);
  }
  report.rms_displacement = std::sqrt(squares);
}

}  // namespace

Result<PoseErrorReport> evaluate_poses(const ScanProject& result, const ScanProject& truth,
                                       const PoseErrorOptions& options) {
  const auto views = pose_views(result, truth, options.samples_per_view);
  if (!views) return views.error();
  PoseErrorReport report;
  if (options.fit_common_motion) report.truth_from_result = common_motion(*views, options.robust);
  for (const PosedView& view : *views)
    report.views.push_back(pose_error(view, report.truth_from_result));
  summarize_views(report);
  for (const RangeView& view : truth.views) {
    const RangeView* found = find_view(result, view.name);
    if (!found || found->pose == PoseKind::kAbsent) report.unmatched.push_back(view.name);
  }
  return report;
}

}  // namespace relief::evaluation
