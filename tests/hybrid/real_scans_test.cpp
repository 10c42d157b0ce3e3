#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "relief/io/project_io.h"
#include "scan/grid/grid_normals.h"
#include "tests/support/result_matchers.h"
#include "tests/support/test_data.h"

namespace relief::hybrid {
namespace {

double median_angle_deg(const Grid<Eigen::Vector3f>& a, const Grid<Eigen::Vector3f>& b) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].allFinite() && b[i].allFinite())
      angles.push_back(std::atan2(a[i].cross(b[i]).norm(), a[i].dot(b[i])));
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle * 180.0 / std::numbers::pi;
}

TEST(RefineRealScans, TheGeometryOfThePanelTakesUpItsMeasuredNormals) {
  RELIEF_REQUIRE_TEST_DATA(panel, "panel");
  ReadProjectOptions read_options;
  read_options.fc_file = panel / "panel-small.fc";
  const auto project = value_of(read_project(panel / "panel-small-conf.ply", read_options));
  const RangeView& view = project.views.front();
  const GridEdges edges = connect_samples(view);
  const auto refined = value_of(refine_view(view));
  EXPECT_EQ(refined.status, RefineStatus::kRefined);
  const double before = median_angle_deg(finite_difference_normals(view, edges), view.normals);
  const double after =
      median_angle_deg(finite_difference_normals(refined.view, edges), view.normals);
  EXPECT_GT(before, 10.0);
  // The rest is smooth bias of the measured normals, which the refined geometry does not take up.
  EXPECT_LT(after, 0.8 * before);
  EXPECT_LT(median_angle_deg(finite_difference_normals(refined.view, edges), refined.view.normals),
            3.0);
}

}  // namespace
}  // namespace relief::hybrid
