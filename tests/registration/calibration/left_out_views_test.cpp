#include "registration/calibration/selection/left_out_views.h"

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "tests/registration/calibration/random_pairs.h"

namespace relief::registration {
namespace {

using testing::kViews;
using testing::RandomProblem;
using testing::Row;

LeftOutViewsTest left_out_views(const RandomProblem& problem, const std::vector<bool>& held,
                                bool per_view) {
  return {fold_system(problem.pairs, problem.sensors, held, per_view), problem.pairs,
          problem.sensors};
}

// (C4) by solving for each view and each fold anew.
TEST(LeftOutViews, GainAsWhenEachIsLeftOut) {
  const RandomProblem problem;
  std::vector<bool> held(kViews, false);
  held[0] = true;
  ErrorModel model;
  model.prior_deviation = 0.2;
  model.add({SensorError::kRangeOffset, false}, problem.sensors);
  ASSERT_EQ(model.parameters.size(), 1u);

  const Eigen::Index size = 6 * kViews + problem.terms;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  std::vector<bool> poses(static_cast<std::size_t>(size), false), all = poses;
  for (std::size_t i = 0; i < 6 * kViews; ++i) poses[i] = all[i] = true;
  const std::size_t offset = 6 * kViews + model.parameters[0].term;
  all[offset] = true;

  const auto gains = left_out_views(problem, held, false).gains(model);
  ASSERT_EQ(gains.size(), kViews);
  for (std::size_t view = 0; view < kViews; ++view) {
    const auto touches = [&](const Row& row) { return row.source == view || row.target == view; };
    const Eigen::VectorXd found =
        problem.minimum([&](const Row& row) { return !touches(row); }, all, zero, model.prior());
    Eigen::VectorXd corrected = zero;
    corrected[static_cast<Eigen::Index>(offset)] = found[static_cast<Eigen::Index>(offset)];
    double gain = 0.0;
    for (std::size_t f = 0; f < kFolds; ++f) {
      const auto others = [&](const Row& row) { return row.fold != f; };
      const auto test = [&](const Row& row) { return row.fold == f && touches(row); };
      gain += problem.squares(test, problem.minimum(others, poses, zero, 0.0)) -
              problem.squares(test, problem.minimum(others, poses, corrected, 0.0));
    }
    EXPECT_NEAR(gains[view], 0.5 * gain, 1e-6 * gain) << view;
    EXPECT_GT(gain, 0.0) << view;
  }
}

// Errors of other views are known without a view, its own are not.
TEST(LeftOutViews, GainByTheErrorsOfTheOthers) {
  const RandomProblem problem;
  const std::vector<bool> held(kViews, false);
  ErrorModel model;
  model.add({SensorError::kRangeOffset, true}, problem.sensors);
  for (const double gain : left_out_views(problem, held, true).gains(model)) EXPECT_GT(gain, 0.0);
}

}  // namespace
}  // namespace relief::registration
