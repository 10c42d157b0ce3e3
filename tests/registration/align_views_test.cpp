#include "relief/registration/align_views.h"

#include <algorithm>
#include <cstring>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/pairwise/icp.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::mean_displacements;
using ::testing::Not;
using testing::perturbed;
using testing::poses_of;

constexpr double kAngle = 0.05;  // [rad], just under three degrees

const std::vector<RangeView>& true_ring() {
  static const std::vector<RangeView> views = testing::ring_of_views();
  return views;
}

double spacing() {
  static const double value = sample_spacing(true_ring()[0]);
  return value;
}

std::vector<RangeView> disturbed_ring() {
  return perturbed(true_ring(), Eigen::Vector3d::Zero(), kAngle, 2.0 * spacing());
}

// Of more samples: poses far off show in what they hide.
std::vector<RangeView> fine_disturbed_ring() {
  const auto views = testing::ring_of_views({.pixels = 160});
  return perturbed(views, Eigen::Vector3d::Zero(), kAngle, 2.0 * sample_spacing(views[0]));
}

double largest_error(const Alignment& alignment) {
  const auto errors =
      mean_displacements(true_ring(), alignment.world_from_view(), poses_of(true_ring()));
  return *std::max_element(errors.begin(), errors.end()) / spacing();
}

bool same_bytes(const RigidMotion& a, const RigidMotion& b) {
  return std::memcmp(a.data(), b.data(), 16 * sizeof(double)) == 0;
}

double largest_difference(const std::vector<RigidMotion>& a, const std::vector<RigidMotion>& b) {
  const auto differences = mean_displacements(true_ring(), a, b);
  return *std::max_element(differences.begin(), differences.end()) / spacing();
}

TEST(AlignViews, ClosesARingOfNoisyViews) {
  const auto aligned = value_of(align_views(disturbed_ring()));
  EXPECT_TRUE(aligned.complete());
  EXPECT_EQ(aligned.termination, RefinementTermination::kConverged);
  EXPECT_LT(largest_error(aligned), 0.1);
  ASSERT_FALSE(aligned.solves.empty());
  EXPECT_EQ(aligned.solves.front().stage, SolverStage::kJoint);
  EXPECT_EQ(aligned.solves.back().stage, SolverStage::kPoseGraph);
  EXPECT_EQ(aligned.solves.size(), static_cast<std::size_t>(aligned.iterations));
  EXPECT_TRUE(same_bytes(aligned.views[0].world_from_view, true_ring()[0].world_from_view));
  const std::string all = std::to_string(aligned.views.size());
  EXPECT_THAT(aligned.notes, Contains(HasSubstr("refining moved the " + all + " views")));
  EXPECT_THAT(aligned.notes, Not(Contains(HasSubstr("by 0 (median)"))));
  for (const auto& view : aligned.views)
    EXPECT_NEAR(view.world_from_view.linear().determinant(), 1.0, 1e-12);
}

TEST(AlignViews, ViewsStandStillWhereTheLastStepIsSmallBesideTheErrorsOfPoses) {
  Alignment aligned;
  aligned.termination = RefinementTermination::kIterationLimit;
  aligned.views.resize(3);
  for (ViewReport& view : aligned.views) view.aligned = true;
  aligned.views[1].pose_std << 0, 0, 0, 0.03, 0.0, 0.04;  // The first view is held.
  aligned.views[2].pose_std = aligned.views[1].pose_std;
  aligned.last_motion = 0.009;
  EXPECT_TRUE(aligned.stands_still());
  aligned.last_motion = 0.011;
  EXPECT_FALSE(aligned.stands_still());
  aligned.termination = RefinementTermination::kConverged;
  EXPECT_TRUE(aligned.stands_still());
  aligned.termination = RefinementTermination::kSolverFailed;
  EXPECT_FALSE(aligned.stands_still());
}

TEST(AlignViews, TellsTheLastMotionAndTheSpacing) {
  const auto aligned = value_of(align_views(disturbed_ring()));
  EXPECT_NEAR(aligned.spacing, spacing(), 0.1 * spacing());
  EXPECT_GT(aligned.last_motion, 0.0);
  EXPECT_LT(aligned.last_motion, 0.02 * spacing());
}

TEST(AlignViews, AssociatesNearestPointsWhenAskedTo) {
  AlignOptions options;
  options.refinement.association = options.starting_poses.association = Association::kNearest;
  const auto aligned = value_of(align_views(disturbed_ring(), options));
  EXPECT_TRUE(aligned.complete());
  EXPECT_LT(largest_error(aligned), 0.1);
}

TEST(AlignViews, RefusesToProjectIntoACameraThatCannot) {
  std::vector<RangeView> views = disturbed_ring();
  Grid<Ray> rays(views[2].width(), views[2].height(), Ray{});
  for (int v = 0; v < rays.height(); ++v)
    for (int u = 0; u < rays.width(); ++u) rays(u, v) = views[2].camera.ray(u, v);
  views[2].camera = Camera::ray_table(rays, std::nullopt);
  views[2].name = "table";
  AlignOptions options;
  options.refinement.association = Association::kProjective;
  EXPECT_THAT(align_views(views, options), HasError(ErrorKind::kBadInput, "view table"));
}

TEST(AlignViews, DoesNotDependOnTheThreadCount) {
  const auto views = disturbed_ring();
  AlignOptions options;
  options.refinement.correspondences = 300;
  std::optional<Alignment> first;
  for (const int threads : testing::compared_threads({1, 2, 4})) {
    const Alignment aligned = value_of(align_views(views, options, {.threads = threads}));
    if (!first) first = aligned;
    for (std::size_t i = 0; i < views.size(); ++i) {
      EXPECT_TRUE(same_bytes(first->views[i].world_from_view, aligned.views[i].world_from_view));
      EXPECT_EQ(first->views[i].pose_std, aligned.views[i].pose_std);
    }
  }
}

TEST(AlignViews, DoesNotDependOnTheOrderOfTheViewsNorOnWhichIsHeld) {
  const auto views = disturbed_ring();
  const auto first = align_views(views)->world_from_view();
  auto other = views;
  other[3].pose = PoseKind::kKnown;
  EXPECT_LT(largest_difference(first, align_views(other)->world_from_view()), 5e-3);

  constexpr std::size_t kOrder[] = {5, 2, 7, 0, 3, 6, 1, 4};
  std::vector<RangeView> shuffled;
  for (const std::size_t i : kOrder) shuffled.push_back(views[i]);
  const auto found = align_views(shuffled)->world_from_view();
  std::vector<RigidMotion> back(views.size());
  for (std::size_t k = 0; k < views.size(); ++k) back[kOrder[k]] = found[k];
  EXPECT_LT(largest_difference(first, back), 5e-3);
}

// ICP from view to view drifts; all pairs together close the ring.
TEST(AlignViews, ClosesARingOf24ViewsStartedFromSequentialIcp) {
  const auto truth = testing::ring_of_views({.views = 24, .pixels = 100});
  auto views = perturbed(truth, Eigen::Vector3d::Zero(), 0.03, 1.0);
  std::vector<ViewSurface> surfaces;
  for (const auto& view : views) surfaces.emplace_back(view);
  for (std::size_t i = 1; i < views.size(); ++i) {
    const RigidMotion guess = truth[i - 1].world_from_view.inverse() * views[i].world_from_view;
    const auto found = align_pair(surfaces[i], surfaces[i - 1], guess);
    ASSERT_TRUE(found.usable());
    views[i].world_from_view = views[i - 1].world_from_view * found.target_from_source;
  }
  const auto worst = [&](const std::vector<RigidMotion>& poses) {
    const auto errors = mean_displacements(truth, poses, poses_of(truth));
    return *std::max_element(errors.begin(), errors.end()) / sample_spacing(truth[0]);
  };
  const auto closed = refine_jointly(surfaces, poses_of(views),
                                     std::vector<ViewRole>(views.size(), ViewRole::kFree));
  EXPECT_LT(worst(closed->world_from_view), 0.1);
  EXPECT_LT(worst(closed->world_from_view), 0.8 * worst(poses_of(views)));
  for (const auto& pair : closed->pairs) EXPECT_NE(pair.status, PairStatus::kMisfit);
}

TEST(AlignViews, AKnownViewThatOverlapsNoOtherConfirmsNothing) {
  auto views = testing::ring_of_views({.pixels = 64});
  views[0].pose = PoseKind::kKnown;
  views[0].world_from_view = Eigen::Translation3d(1000, 0, 0) * views[0].world_from_view;
  const auto aligned = align_views(views, {});
  ASSERT_TRUE(aligned) << aligned.error().message;
  EXPECT_EQ(aligned->views[0].status, PoseStatus::kUnverified);
  EXPECT_EQ(aligned->views[0].world_from_view.matrix(), views[0].world_from_view.matrix());
  for (std::size_t i = 1; i < views.size(); ++i)
    EXPECT_EQ(aligned->views[i].status, PoseStatus::kVerified) << i;
}

TEST(AlignViews, AKnownPoseThatDeviatesAsNoOtherDoesIsUnverified) {
  auto views = true_ring();
  for (RangeView& view : views) view.pose = PoseKind::kKnown;
  views[3].world_from_view =
      Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()) * views[3].world_from_view;
  const auto aligned = value_of(align_views(views));
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_EQ(aligned.views[i].status, i == 3 ? PoseStatus::kUnverified : PoseStatus::kVerified)
        << i;
  EXPECT_TRUE(same_bytes(aligned.views[3].world_from_view, views[3].world_from_view));
}

// As of a turntable whose angles have the wrong sign.
TEST(AlignViews, TellsOfGivenPosesThatTurnTheWrongWayRound) {
  auto views = true_ring();
  const Eigen::DiagonalMatrix<double, 3> mirror(-1.0, 1.0, 1.0);
  for (RangeView& view : views) {
    RigidMotion& pose = view.world_from_view;
    pose.linear() = mirror * pose.linear() * mirror;
    pose.translation() = mirror * pose.translation();
  }
  const auto aligned = value_of(align_views(views));
  EXPECT_THAT(aligned.notes, Contains(HasSubstr("are the given ones in a mirror")));
  EXPECT_LT(largest_error(aligned), 0.2);
}

TEST(AlignViews, KeepsKnownPosesToTheBit) {
  auto views = disturbed_ring();
  for (const std::size_t known : {2u, 5u}) {
    views[known].world_from_view = true_ring()[known].world_from_view;
    views[known].pose = PoseKind::kKnown;
  }
  const auto aligned = align_views(views);
  for (const std::size_t known : {2u, 5u}) {
    EXPECT_TRUE(same_bytes(aligned->views[known].world_from_view, views[known].world_from_view));
    EXPECT_TRUE(aligned->views[known].pose_std.isZero());
  }
  EXPECT_LT(largest_error(*aligned), 0.1);
}

TEST(AlignViews, MovesWithTheWorld) {
  auto views = disturbed_ring();
  const auto here = align_views(views);
  RigidTangent tangent;
  tangent << 0.5, -1.0, 2.0, 1e6 * spacing(), -1e6 * spacing(), 3e5 * spacing();
  const RigidMotion elsewhere = motion_from_tangent(tangent);
  for (auto& view : views) view.world_from_view = elsewhere * view.world_from_view;
  const auto there = align_views(views);
  EXPECT_LT(largest_error(*there), 0.1);
  EXPECT_LT(largest_difference(here->world_from_view(), there->world_from_view()), 1e-3);
}

TEST(AlignViews, DoesNotDependOnTheUnit) {
  auto views = disturbed_ring();
  const auto millimetres = align_views(views);
  for (auto& view : views) {  // A pinhole view scales with its range.
    for (double& range : view.range) range *= 1e-3;
    view.world_from_view.translation() *= 1e-3;
  }
  const auto metres = align_views(views);
  auto poses = metres->world_from_view();
  for (auto& pose : poses) pose.translation() *= 1e3;
  EXPECT_LT(largest_difference(millimetres->world_from_view(), poses), 1e-3);
  EXPECT_NEAR(metres->rms, 1e-3 * millimetres->rms, 1e-6 * millimetres->rms);
}

TEST(AlignViews, AlignsAViewWithItsDuplicate) {
  const RangeView view = true_ring()[0];
  const auto views = perturbed({view, view}, Eigen::Vector3d::Zero(), kAngle, spacing());
  const auto aligned = align_views(views);
  ASSERT_TRUE(aligned->complete());
  EXPECT_TRUE(aligned->views[1].world_from_view.isApprox(view.world_from_view, 1e-5));
}

TEST(AlignViews, ReportsViewsThatOverlapNothing) {
  auto views = disturbed_ring();
  views.resize(3);
  views[2].world_from_view = Eigen::Translation3d(1e4, 0, 0) * views[2].world_from_view;
  AlignOptions options;
  options.starting_poses.given = GivenPoses::kTrust;
  const auto aligned = value_of(align_views(views, options));
  EXPECT_TRUE(aligned.complete());
  EXPECT_EQ(aligned.views[0].status, PoseStatus::kVerified);
  EXPECT_EQ(aligned.views[1].status, PoseStatus::kVerified);
  EXPECT_EQ(aligned.views[2].status, PoseStatus::kUnverified);
  EXPECT_THAT(aligned.views[2].reason, HasSubstr("overlaps no other view"));
  EXPECT_TRUE(same_bytes(aligned.views[2].world_from_view, views[2].world_from_view));
}

// Its depths in metres among others in millimetres, or the other way round.
TEST(AlignViews, LeavesOutAViewOfAnotherUnitUnlessItsPoseIsTrusted) {
  for (const double factor : {1e3, 1e-3}) {
    auto views = disturbed_ring();
    views.resize(4);
    for (double& range : views[3].range) range *= factor;
    AlignOptions options;
    const auto aligned = value_of(align_views(views, options));
    for (std::size_t i = 0; i < views.size(); ++i)
      EXPECT_EQ(aligned.views[i].status, i == 3 ? PoseStatus::kLeftOut : PoseStatus::kVerified);
    EXPECT_THAT(aligned.views[3].reason,
                HasSubstr(factor > 1.0 ? "times as far apart" : "times as near"));
    EXPECT_THAT(aligned.views[3].reason, HasSubstr("check its unit"));
    options.starting_poses.given = GivenPoses::kTrust;
    EXPECT_TRUE(value_of(align_views(views, options)).complete());
    options.starting_poses.given = GivenPoses::kIgnore;
    EXPECT_THAT(value_of(align_views(views, options)).views[3].reason, HasSubstr("check its unit"));
  }
}

TEST(AlignViews, KeepsGivenPosesThatNothingConfirmsAndSaysSo) {
  const auto aligned = value_of(align_views({true_ring()[0], true_ring()[4]}));
  EXPECT_EQ(aligned.termination, RefinementTermination::kNoOverlap);
  for (const auto& view : aligned.views) {
    EXPECT_TRUE(view.aligned);
    EXPECT_EQ(view.status, PoseStatus::kUnverified);
    EXPECT_THAT(view.reason, HasSubstr("nothing confirms it"));
  }
}

TEST(AlignViews, AlignsNeitherOfTwoViewsWithoutPosesThatDoNotOverlap) {
  std::vector<RangeView> views = {true_ring()[0], true_ring()[4]};
  for (auto& view : views) view.pose = PoseKind::kAbsent;
  const auto aligned = value_of(align_views(views));
  for (const auto& view : aligned.views) EXPECT_EQ(view.status, PoseStatus::kLeftOut);
}

TEST(AlignViews, NeverSplitsANetworkThatTheUserGave) {
  auto views = disturbed_ring();
  const RigidMotion apart(Eigen::Translation3d(0, 0, 1e4));
  for (const std::size_t i : {0u, 1u, 2u})
    views[i].world_from_view = apart * views[i].world_from_view;
  AlignOptions options;
  options.starting_poses.given = GivenPoses::kTrust;
  const auto aligned = align_views(views, options);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_TRUE(aligned->views[i].aligned);
    EXPECT_EQ(aligned->views[i].status == PoseStatus::kVerified, i > 2);
  }
  EXPECT_THAT(aligned->views[1].reason, HasSubstr("confirmed only by view0, view2"));
  // Each group is aligned all the same.
  auto poses = aligned->world_from_view();
  const std::vector<RangeView> group(views.begin(), views.begin() + 3);
  const auto errors = mean_displacements(group, {poses[0], poses[1], poses[2]},
                                         poses_of({true_ring().begin(), true_ring().begin() + 3}));
  for (const double error : errors) EXPECT_LT(error, 0.2 * spacing());
}

// Two objects that never meet: nothing confirms the poses between them.
TEST(AlignViews, KeepsGivenPosesThatAViewIsJoinedToByItsShape) {
  const auto other = testing::ring_of_views({.radius = 35.0, .centre = {400, 0, 0}});
  std::vector<RangeView> views(true_ring().begin(), true_ring().begin() + 3);
  views.insert(views.end(), other.begin(), other.begin() + 3);
  for (std::size_t i = 3; i < views.size(); ++i) views[i].name = "other" + std::to_string(i);
  views.back().pose = PoseKind::kAbsent;
  views.back().world_from_view = RigidMotion::Identity();
  const auto aligned = value_of(align_views(views));
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_TRUE(aligned.views[i].aligned) << aligned.views[i].reason;
  EXPECT_TRUE(aligned.views[5].world_from_view.isApprox(other[2].world_from_view, 1e-3));
}

TEST(AlignViews, TakesOutAViewWhosePoseIsFarOff) {
  auto views = fine_disturbed_ring();
  const RigidMotion off(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()));
  views[3].world_from_view = off * views[3].world_from_view;
  AlignOptions options;
  options.starting_poses.search = false;
  const auto aligned = value_of(align_views(views, options));
  for (std::size_t i = 0; i < views.size(); ++i) EXPECT_EQ(aligned.views[i].aligned, i != 3);
  EXPECT_THAT(aligned.views[3].reason, HasSubstr("other views saw through"));
  // The others are none the worse for it.
  auto truth = poses_of(true_ring()), found = aligned.world_from_view();
  views.erase(views.begin() + 3);
  truth.erase(truth.begin() + 3);
  found.erase(found.begin() + 3);
  for (const double error : mean_displacements(views, found, truth))
    EXPECT_LT(error, 0.15 * spacing());
}

// As the arm of a robot that holds the camera: it stands where other views see the object.
TEST(AlignViews, KeepsAViewInWhichSomethingMoved) {
  auto views = fine_disturbed_ring();
  RangeView& view = views[3];
  for (int v = 20; v < view.height(); ++v)
    for (int u = 65; u < view.width(); ++u)
      if (view.has_sample(u, v)) view.range(u, v) -= 12.0;
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.views[3].aligned) << aligned.views[3].reason;
  EXPECT_EQ(aligned.views[3].status, PoseStatus::kUnverified);
  EXPECT_THAT(aligned.views[3].reason, HasSubstr("other views saw through where a part"));
  for (const double error :
       mean_displacements(views, aligned.world_from_view(), poses_of(true_ring())))
    EXPECT_LT(error, 0.5 * spacing());
}

// The radius of a view of one sample is 0.
TEST(AlignViews, AViewOfOneSampleIsNoError) {
  for (const bool with_poses : {true, false}) {
    auto views = disturbed_ring();
    views.resize(4);
    const auto [u, v] = std::pair(80, 80);
    for (int y = 0; y < views[2].height(); ++y)
      for (int x = 0; x < views[2].width(); ++x)
        if (std::max(std::abs(x - u), std::abs(y - v)) > 2) views[2].range(x, y) = kNoSample;
    if (!with_poses)
      for (RangeView& view : views) view.pose = PoseKind::kAbsent;
    const auto aligned = value_of(align_views(views));
    EXPECT_TRUE(aligned.views[0].aligned && aligned.views[1].aligned);
  }
}

TEST(AlignViews, TellsThatViewsWereFoundAtOnePlace) {
  std::vector<RangeView> views(4, true_ring().front());
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].name = "v" + std::to_string(i);
    views[i].pose = PoseKind::kAbsent;
    testing::add_range_noise(views[i], 0.05 * spacing(), static_cast<std::uint32_t>(i + 1));
  }
  EXPECT_THAT(value_of(align_views(views)).notes,
              ::testing::Contains(HasSubstr("4 views were found where another one is")));
}

TEST(AlignViews, BringsBackAHeldViewThatIsFarOff) {
  auto views = disturbed_ring();
  const RigidMotion off(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  views[0].world_from_view = off * views[0].world_from_view;
  const auto aligned = align_views(views);
  EXPECT_TRUE(aligned->complete());
  EXPECT_LT(largest_error(*aligned), 0.1);
}

TEST(AlignViews, LeavesViewsWithHardlyAnySamples) {
  auto views = disturbed_ring();
  views.resize(3);
  std::fill(views[1].range.begin(), views[1].range.end(), kNoSample);
  std::fill(views[2].range.begin(), views[2].range.end(), kNoSample);
  views[2].range(80, 80) = true_ring()[2].range(80, 80);
  const auto aligned = value_of(align_views(views));
  for (const std::size_t i : {1u, 2u}) {
    EXPECT_FALSE(aligned.views[i].aligned);
    EXPECT_THAT(aligned.views[i].reason, HasSubstr("no usable samples"));
  }
}

TEST(AlignViews, OfOneViewIsThatView) {
  const auto aligned = value_of(align_views({true_ring()[1]}));
  EXPECT_TRUE(aligned.complete());
  EXPECT_TRUE(same_bytes(aligned.views[0].world_from_view, true_ring()[1].world_from_view));
  EXPECT_THAT(aligned.notes, ::testing::Contains(HasSubstr("one view only")));
}

TEST(AlignViews, RejectsNoViewsAndBadOptions) {
  EXPECT_THAT(align_views({}), HasError());
  AlignOptions options;
  options.refinement.min_overlap = 2.0;
  EXPECT_THAT(align_views({true_ring()[0]}, options),
              HasError("refinement.min_overlap must be in (0, 1]"));
}

TEST(AlignViews, StopsWhenAsked) {
  const auto stopped = align_views(disturbed_ring(), {},
                                   {.progress = [](double, std::string_view) { return false; }});
  EXPECT_THAT(stopped, HasError(ErrorKind::kInterrupted));
}

TEST(AlignViews, FindsPosesOfATurntableWithoutAnyGuess) {
  const auto truth = testing::ring_of_views({.views = 12, .tilts = {0.3, 0.3}});
  auto views = truth;
  for (auto& view : views) {
    view.pose = PoseKind::kAbsent;
    view.world_from_view = RigidMotion::Identity();
  }
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.complete());
  for (const double error : mean_displacements(truth, aligned.world_from_view(), poses_of(truth)))
    EXPECT_LT(error, 0.2 * spacing());
  EXPECT_THAT(aligned.notes, ::testing::Contains(HasSubstr("were joined by their shape")));
}

}  // namespace
}  // namespace relief::registration
