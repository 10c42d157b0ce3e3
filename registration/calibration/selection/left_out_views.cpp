#include "registration/calibration/selection/left_out_views.h"

#include <algorithm>

#include "registration/calibration/selection/held_out.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Groups of views at most. Up to so many views are left out one by one. The sums of a group of
// twice as many views with errors apart take ten megabytes, so there are fewer groups then.
constexpr std::size_t kMostGroups = 12;

std::size_t most_groups(std::size_t views, bool per_view) {
  return per_view && views > 2 * kMostGroups ? kMostGroups / 2 : kMostGroups;
}

// Of a pair that touches a group: it touches that of its other view as well.
constexpr double kShare = 0.5;

// The group of each view that shares surface with others. Views that follow each other, which are
// often neighbours, are in different groups.
std::vector<std::size_t> groups_of(const std::vector<PairSums>& pairs, std::size_t views,
                                   std::size_t most, std::size_t& groups) {
  std::vector<bool> linked(views, false);
  for (const PairSums& pair : pairs)
    if (pair.deviation > 0.0) linked[pair.source] = linked[pair.target] = true;
  std::vector<std::size_t> group(views, most);
  std::size_t count = 0;
  for (std::size_t i = 0; i < views; ++i)
    if (linked[i]) group[i] = count++ % most;
  groups = std::min(count, most);
  return group;
}

}  // namespace

LeftOutViewsTest::LeftOutViewsTest(const FoldSystem& system, const std::vector<PairSums>& pairs,
                                   const Sensors& sensors)
    : sensors_(sensors), layout_(system.layout) {
  const std::size_t views = layout_.pose.size();
  std::size_t groups = 0;
  const std::vector<std::size_t> group =
      groups_of(pairs, views, most_groups(views, layout_.per_view), groups);
  groups_ = parallel_map<Group>(groups, [&](std::size_t g) {
    const auto touches = [&](const PairSums& pair) {
      return group[pair.source] == g || group[pair.target] == g;
    };
    Group result;
    SystemSum train(layout_);
    result.test = ReducedSum(layout_.coefficients);
    for (std::size_t f = 0; f < kFolds; ++f) {
      SystemSum touched(layout_);
      for (const PairSums& pair : pairs)
        (touches(pair) ? touched : train).add(pair, f, sensors, layout_);
      const ReducedSum test = system.folds[f].poses_of_others.reduce(touched, layout_);
      result.test.matrix += test.matrix;
      result.test.gradient += test.gradient;
    }
    result.train = EliminatedPoses(train, layout_).reduce(train, layout_);
    if (!layout_.per_view) return result;
    result.common_motion = ReducedSum(layout_.coefficients);
    for (const PairSums& pair : pairs)
      if (!touches(pair)) add_common_motion(pair, sensors, layout_, result.common_motion);
    return result;
  });
}

std::vector<double> LeftOutViewsTest::gains(const ErrorModel& model) const {
  const auto coefficients = layout_.coefficients_of(model, sensors_);
  return parallel_map<double>(groups_.size(), [&](std::size_t g) {
    if (coefficients.empty()) return 0.0;
    ReducedSum train = groups_[g].train.by_parameters(coefficients);
    train.matrix += prior_of(model, coefficients, groups_[g].common_motion);
    const Eigen::VectorXd found = -solve_symmetric(train.matrix, train.gradient);
    return kShare * groups_[g].test.by_parameters(coefficients).fall(found);
  });
}

}  // namespace relief::registration
