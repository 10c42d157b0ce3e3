#include "relief/evaluation/view_errors.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relief/scan/discontinuities.h"
#include "scan/grid/connected_grid.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::evaluation {
namespace {

const Camera kCamera = Camera::pinhole(120, 100, {150, 150, 59.5, 49.5});

ScanProject project_of(const RangeView& view, const std::string& name = "a") {
  ScanProject project;
  project.views = {view};
  project.views[0].name = name;
  return project;
}

RangeView sphere_view(const Camera& camera = kCamera) {
  const double z = camera.model() == Camera::Model::kPinholeGl ? -10.0 : 10.0;
  return testing::render(testing::sphere({0, 0, z}, 2.5), camera);
}

TEST(EvaluateViews, TheTruthHasNoErrors) {
  const auto report =
      value_of(evaluate_views(project_of(sphere_view()), project_of(sphere_view())));
  EXPECT_EQ(report.overall.depth.all.max, 0.0);
  EXPECT_EQ(report.overall.depth.all.count, sphere_view().sample_count());
  EXPECT_LT(report.overall.map_normals_deg.all.max, 1e-3);
  EXPECT_LT(report.overall.position_normals_deg.inner.median, 0.1);  // central differences
  EXPECT_GT(report.overall.position_normals_deg.all.max, 0.0);
  EXPECT_EQ(report.overall.sampled_normals_deg.all.max, 0.0);  // the same ones
  EXPECT_EQ(report.overall.sampled_normals_deg.all.count,
            report.overall.position_normals_deg.all.count);
  EXPECT_EQ(report.overall.missing + report.overall.extra, 0u);
}

TEST(EvaluateViews, DepthIsLengthAlongTheRayInEveryCameraConvention) {
  for (const Camera& camera :
       {kCamera, Camera::pinhole_gl(120, 100, {150, 150, 59.5, 49.5}),
        Camera::orthographic(120, 100, {-3, -2.5, 0}, {0.05, 0, 0}, {0, 0.05, 0}, {0, 0, 2})}) {
    const RangeView truth = sphere_view(camera);
    RangeView shifted = truth;
    for (int v = 0; v < 100; ++v)
      for (int u = 0; u < 120; ++u) shifted.range(u, v) += 0.03 / camera.ray(u, v).direction.norm();
    const auto report = value_of(evaluate_views(project_of(shifted), project_of(truth)));
    const ErrorStatistics& depth = report.views[0].depth.all;
    for (const double value : {depth.mean, depth.median, depth.rms, depth.p95, depth.max})
      EXPECT_NEAR(value, 0.03, 1e-12);
    EXPECT_NEAR(report.views[0].depth_bias, 0.03, 1e-12);
  }
}

TEST(EvaluateViews, ReportsTheNoiseThatWasAdded) {
  const RangeView truth = testing::render(testing::plane({0, 0, 10}, {0.2, 0.1, -1}), kCamera);
  RangeView noisy = truth;
  testing::add_range_noise(noisy, 0.002, 3);
  testing::add_normal_noise(noisy, 0.02, 4);
  const auto report = value_of(evaluate_views(project_of(noisy), project_of(truth)));
  EXPECT_NEAR(report.overall.depth.all.rms, 0.002, 0.0001);
  EXPECT_NEAR(report.overall.depth_bias, 0.0, 0.0001);
  EXPECT_NEAR(report.overall.map_normals_deg.all.rms,
              0.02 * std::sqrt(2.0) * 180.0 / std::numbers::pi, 0.05);
  // Central differences over two spacings of 1/15: slope noise sigma / (sqrt 2 spacing) an axis.
  EXPECT_NEAR(report.overall.position_normals_deg.inner.rms,
              0.002 / (10.0 / 150.0) * 180.0 / std::numbers::pi, 0.25);
  EXPECT_NEAR(report.overall.sampled_normals_deg.inner.rms,
              report.overall.position_normals_deg.inner.rms, 1e-3);  // exact on a plane
}

TEST(EvaluateViews, SeparatesDiscontinuitiesFromTheInside) {
  const RangeView truth = sphere_view();
  RangeView result = truth;
  const auto to_boundary = boundary_distance(truth, connect_samples(truth));
  for (std::size_t i = 0; i < result.range.size(); ++i)
    if (to_boundary[i] <= 2) result.range[i] += 0.1;
  const auto report = value_of(evaluate_views(project_of(result), project_of(truth)));
  const SplitStatistics& depth = report.views[0].depth;
  EXPECT_EQ(depth.inner.max, 0.0);
  EXPECT_GT(depth.edge.median, 0.099);
  EXPECT_EQ(depth.inner.count + depth.edge.count, depth.all.count);
  EXPECT_GT(depth.edge.count, 100u);
}

TEST(EvaluateViews, CountsMissingAndExtraSamples) {
  RangeView truth = sphere_view(), result = sphere_view();
  result.range(60, 50) = kNoSample;
  truth.range(61, 50) = truth.range(62, 50) = kNoSample;
  const auto report = value_of(evaluate_views(project_of(result), project_of(truth)));
  EXPECT_EQ(report.views[0].missing, 1u);
  EXPECT_EQ(report.views[0].extra, 2u);
}

TEST(EvaluateViews, PoolsViewsAndListsUnmatchedOnes) {
  ScanProject truth = project_of(sphere_view(), "a"), result = truth;
  truth.views.push_back(truth.views[0]);
  truth.views[1].name = "b";
  truth.views.push_back(truth.views[0]);
  truth.views[2].name = "c";
  result.views.push_back(truth.views[1]);
  for (double& t : result.views[1].range) t *= 1.01;
  const auto report = value_of(evaluate_views(result, truth, {}, {.threads = 2}));
  EXPECT_EQ(report.overall.depth.all.count,
            report.views[0].depth.all.count + report.views[1].depth.all.count);
  EXPECT_NEAR(report.overall.depth.all.mean, 0.5 * report.views[1].depth.all.mean, 1e-12);
  EXPECT_EQ(report.unmatched, std::vector<std::string>{"c"});
}

TEST(EvaluateViews, TakesTrueNormalsFromPositionsWhereNoneAreGiven) {
  RangeView truth = sphere_view();
  truth.normals = {};
  const auto report = value_of(evaluate_views(project_of(sphere_view()), project_of(truth)));
  EXPECT_EQ(report.overall.position_normals_deg.all.max, 0.0);
  EXPECT_LT(report.overall.map_normals_deg.inner.median, 0.1);
}

TEST(EvaluateViews, SaysWhyViewsCannotBeCompared) {
  const ScanProject truth = project_of(sphere_view());
  const auto compare = [&](const ScanProject& result) { return evaluate_views(result, truth); };
  EXPECT_THAT(compare(project_of(sphere_view(), "z")), HasError("no view of this name"));
  const Camera other = Camera::pinhole(120, 99, {150, 150, 59.5, 49.5});
  EXPECT_THAT(compare(project_of(sphere_view(other))), HasError("120x99"));
  const Camera longer = Camera::pinhole(120, 100, {155, 155, 59.5, 49.5});
  EXPECT_THAT(compare(project_of(sphere_view(longer))), HasError("rays"));
}

}  // namespace
}  // namespace relief::evaluation
