#include "relief/reconstruction/alignment_gain.h"

#include <cassert>
#include <cmath>

#include "scan/base/median.h"

namespace relief::reconstruction {

namespace {

std::vector<const registration::ViewReport*> aligned_views(
    const registration::Alignment& alignment) {
  std::vector<const registration::ViewReport*> aligned;
  for (const registration::ViewReport& view : alignment.views)
    if (view.aligned) aligned.push_back(&view);
  return aligned;
}

// Of the noise alone: errors of the sensors are in both alignments. Held views have none: they are
// what the others are known against.
double median_pose_std(const registration::Alignment& alignment) {
  std::vector<double> deviations;
  for (const registration::ViewReport* view : aligned_views(alignment)) {
    const double variance =
        (view->pose_covariance - view->sensor_covariance).diagonal().tail<3>().sum();
    if (variance > 0.0) deviations.push_back(std::sqrt(variance));
  }
  return deviations.empty() ? 0.0 : median(deviations);
}

// Mean distance between two places of the samples, of one in kStride x kStride.
double mean_motion(const std::vector<RangeView>& views,
                   const std::vector<const registration::ViewReport*>& before,
                   const std::vector<registration::ViewReport>& after) {
  constexpr int kStride = 4;  // [pixels]; bounds the time.
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!after[i].aligned) continue;
    const RangeView& view = views[i];
    for (int v = 0; v < view.height(); v += kStride) {
      for (int u = 0; u < view.width(); u += kStride) {
        if (!view.has_sample(u, v)) continue;
        const Eigen::Vector3d point = view.point(u, v);
        sum += (before[i]->world_from_view * point - after[i].world_from_view * point).norm();
        count += 1.0;
      }
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

GainVerdict verdict_of(const AlignmentGain& gain, const registration::Alignment& second) {
  if (!second.solved()) return GainVerdict::kSolverFailed;
  if (gain.left_out > 0) return GainVerdict::kViewsLost;
  return gain.second_pose_std <= gain.first_pose_std ? GainVerdict::kGain : GainVerdict::kNoGain;
}

}  // namespace

AlignmentGain compare_alignments(const registration::Alignment& first,
                                 const registration::Alignment& second,
                                 const std::vector<RangeView>& views) {
  const auto before = aligned_views(first);
  assert(before.size() == views.size() && second.views.size() == views.size());
  AlignmentGain gain;
  gain.first_rms = first.rms;
  gain.second_rms = second.rms;
  gain.first_pose_std = median_pose_std(first);
  gain.second_pose_std = median_pose_std(second);
  gain.mean_motion = mean_motion(views, before, second.views);
  gain.left_out = views.size() - aligned_views(second).size();
  gain.verdict = verdict_of(gain, second);
  return gain;
}

}  // namespace relief::reconstruction
