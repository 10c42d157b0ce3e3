#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"
#include "tests/support/test_data.h"

namespace relief::registration {
namespace {

using ::testing::HasSubstr;
using testing::mean_displacements;
using testing::poses_of;
using testing::without_poses;

constexpr int kPixels = 112;

const std::vector<RangeView>& ring() {
  static const auto views = testing::ring_of_views({.views = 8, .pixels = kPixels});
  return views;
}

// Every third view and so on: neighbours are no neighbours any more.
std::vector<RangeView> shuffled(const std::vector<RangeView>& views) {
  std::vector<RangeView> result;
  for (std::size_t i = 0; i < views.size(); ++i)
    result.push_back(views[(5 * i + 3) % views.size()]);
  return result;
}

std::vector<RangeView> with_wild_guesses(std::vector<RangeView> views) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (auto& view : views) {
    RigidTangent tangent;
    for (double& x : tangent) x = 2.0 * normal(generator);
    tangent.tail<3>() *= 30.0;
    view.world_from_view = motion_from_tangent(tangent);
    view.pose = PoseKind::kGuess;
  }
  return views;
}

void expect_true_poses(const std::vector<RangeView>& truth, const Alignment& alignment) {
  EXPECT_TRUE(alignment.complete());
  const double spacing = sample_spacing(truth[0]);
  for (const double error : mean_displacements(truth, alignment.world_from_view(), poses_of(truth)))
    EXPECT_LT(error, 0.2 * spacing);
}

bool same_bytes(const RigidMotion& a, const RigidMotion& b) {
  return std::memcmp(a.data(), b.data(), 16 * sizeof(double)) == 0;
}

TEST(GlobalRegistration, FindsShuffledViewsWithoutPosesOnAnyNumberOfThreads) {
  const auto truth = shuffled(ring());
  const auto views = without_poses(truth);
  const auto one = value_of(align_views(views, {}, {.threads = 1}));
  expect_true_poses(truth, one);
  EXPECT_THAT(one.notes, ::testing::Contains(HasSubstr("were joined by their shape")));
  const auto three = align_views(views, {}, {.threads = 3});
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_TRUE(same_bytes(one.views[i].world_from_view, three->views[i].world_from_view));
}

TEST(GlobalRegistration, FindsViewsAnewWhoseGuessesAreWild) {
  const auto truth = shuffled(ring());
  const auto aligned = value_of(align_views(with_wild_guesses(truth)));
  expect_true_poses(truth, aligned);
}

TEST(GlobalRegistration, FindsTheOneViewWhoseGuessIsWildAndLeavesKnownPosesAlone) {
  auto views = ring();
  for (auto& view : views) view.pose = PoseKind::kGuess;
  views[1].pose = views[4].pose = PoseKind::kKnown;
  views[6].world_from_view =
      views[6].world_from_view * Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ());
  const auto aligned = value_of(align_views(views));
  expect_true_poses(ring(), aligned);
  for (const std::size_t known : {1u, 4u})
    EXPECT_TRUE(same_bytes(aligned.views[known].world_from_view, ring()[known].world_from_view));
}

TEST(GlobalRegistration, LeavesOutAViewOfAnotherObject) {
  std::vector<RangeView> views(ring().begin(), ring().begin() + 3);
  // The same object squeezed: alike everywhere, the same nowhere.
  RangeView other = testing::ring_of_views({.views = 8, .pixels = kPixels, .radius = 35.0})[1];
  other.name = "other";
  views.push_back(other);
  const auto aligned = value_of(align_views(without_poses(views)));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(aligned.views[i].aligned);
  EXPECT_FALSE(aligned.views[3].aligned);
  EXPECT_THAT(aligned.views[3].reason, HasSubstr("no pose was found"));
}

// Bent by more than any candidate may be.
TEST(GlobalRegistration, NamesTheBestOfThePosesThatAreNoCandidates) {
  std::vector<RangeView> views(ring().begin(), ring().begin() + 2);
  const double bend = 2.5 * sample_spacing(views[1]);
  for (int v = 0; v < views[1].height(); ++v)
    for (int u = 0; u < views[1].width(); ++u)
      views[1].range(u, v) += bend * std::sin(0.15 * u) * std::cos(0.15 * v);
  const auto aligned = value_of(align_views(without_poses(views)));
  EXPECT_FALSE(aligned.views[1].aligned);
  EXPECT_THAT(aligned.views[1].reason, HasSubstr("the best is next to " + views[0].name));
}

TEST(GlobalRegistration, KeepsTwoObjectsTwoGroups) {
  std::vector<RangeView> views(ring().begin(), ring().begin() + 3);
  for (RangeView& view : testing::ring_of_views(
           {.views = 12, .pixels = kPixels, .radius = 35.0, .tilts = {0.3, 0.3}})) {
    view.name = "small" + view.name;
    if (view.name == "smallview5" || view.name == "smallview6") views.push_back(view);
  }
  const auto aligned = value_of(align_views(without_poses(views)));
  for (std::size_t i = 0; i < views.size(); ++i) EXPECT_EQ(aligned.views[i].aligned, i < 3);
  EXPECT_THAT(aligned.views[3].reason, HasSubstr("aligned only to smallview6"));
}

TEST(GlobalRegistration, DoesNotForceASphere) {
  const Camera camera = Camera::pinhole(100, 100, {200, 200, 49.5, 49.5});
  std::vector<RangeView> views;
  for (const double angle : {0.0, 0.7, 1.4}) {
    views.push_back(testing::render(
        testing::sphere({0, 0, 0}, 40.0), camera,
        testing::look_at({200 * std::cos(angle), 200 * std::sin(angle), 0}, {0, 0, 0})));
    views.back().name = "v" + std::to_string(views.size());
    testing::add_range_noise(views.back(), 0.3, static_cast<std::uint32_t>(views.size()));
  }
  const auto aligned = value_of(align_views(without_poses(views)));
  for (const auto& view : aligned.views) EXPECT_FALSE(view.aligned);
}

TEST(GlobalRegistration, PlacesTheBunnyWithoutPoses) {
  RELIEF_REQUIRE_TEST_DATA(folder, "bunny");
  const auto project = value_of(read_project(folder / "bun.conf"));
  std::vector<RangeView> truth;
  for (std::size_t i = 0; i < project.views.size(); ++i)
    truth.push_back(project.views[(3 * i + 7) % project.views.size()]);
  const auto aligned = value_of(align_views(without_poses(truth)));
  EXPECT_TRUE(aligned.complete());
  const auto errors = mean_displacements(truth, aligned.world_from_view(), poses_of(truth));
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 0.3e-3);  // m
}

}  // namespace
}  // namespace relief::registration
