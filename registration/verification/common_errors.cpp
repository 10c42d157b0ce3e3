#include "registration/verification/common_errors.h"

#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"

namespace relief::registration {

namespace {

constexpr double kBetterQuantile = 0.25;     // Of pairs: right while a quarter of them are.
constexpr double kUnexplainedStddevs = 1.5;  // [deviations of the noise]

}  // namespace

double common_stddev(const std::vector<ViewSurface>& surfaces,
                     const std::vector<PairDeviation>& pairs) {
  std::vector<double> rms, noise, spacing;
  for (const PairDeviation& pair : pairs) {
    const ViewSurface &a = surfaces[pair.a], &b = surfaces[pair.b];
    rms.push_back(pair.rms);
    noise.push_back(joint_noise(a, b));
    spacing.push_back(coarser_spacing(a, b));
  }
  if (rms.empty()) return 0.0;
  const double common = quantile(std::move(rms), kBetterQuantile);
  const bool explained = common <= kUnexplainedStddevs * quantile(std::move(noise), 0.5);
  const bool matters = finest_search_distance(0.0, common) > quantile(std::move(spacing), 0.5);
  return explained || !matters ? 0.0 : common;
}

}  // namespace relief::registration
