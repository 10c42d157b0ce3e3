#include "relief/fusion/merge_views.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/mesh/measured_components.h"
#include "relief/scan/context.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

using ::testing::AllOf;
using testing::box_distance;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::SignedDistance;
using testing::sphere_distance;
using ::testing::StartsWith;
using testing::torus_distance;
using testing::traced;
using testing::views_around;

MergeResult merged(const std::vector<RangeView>& views, const MergeOptions& options = {}) {
  return value_of(merge_views(views, options));
}

double measured_rms(const MergeResult& result, const SignedDistance& distance) {
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    if (result.mesh.filled[v]) continue;
    squares += std::pow(distance(result.mesh.vertices[v]), 2);
    ++count;
  }
  return std::sqrt(squares / static_cast<double>(count));
}

bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.faces == b.faces && a.normals == b.normals &&
         a.quality == b.quality && a.views == b.views && a.source_views == b.source_views &&
         a.filled == b.filled;
}

TEST(MergeViews, LargeVoxelsTakeTheMeanOfTheSamples) {
  const testing::Surface surface = testing::sphere(Eigen::Vector3d::Zero(), 50.0);
  std::vector<RangeView> views = views_around(surface, 8, 320, 50.0);
  const double exact = measured_rms(merged(views, {.voxel_size = 6.0}), sphere_distance(50.0));
  constexpr double kNoise = 0.5;
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], kNoise, static_cast<std::uint32_t>(i));
  const MergeResult result = merged(views, {.voxel_size = 6.0});
  EXPECT_TRUE(result.check.watertight());
  EXPECT_LT(measured_rms(result, sphere_distance(50.0)), std::hypot(exact, 0.25 * kNoise))
      << "of some 16 samples, each view has the mean";
}

TEST(MergeViews, VoxelsThatAreLargeForTheObjectAreNoted) {
  const auto notes = [](double voxel_size) {
    const auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 8, 80, 50.0);
    return merged(views, {.voxel_size = voxel_size}).notes;
  };
  EXPECT_THAT(notes(0.0), IsEmpty());
  EXPECT_THAT(notes(2.5), IsEmpty());
  const auto of_lump = ElementsAre(
      AllOf(StartsWith("warning: voxels of 20 are large"), HasSubstr("4.9 x 4.9 x 4.9 of them")));
  EXPECT_THAT(notes(20.0), of_lump);
}

TEST(MergeViews, ASphereConvergesWithTheSquareOfTheResolution) {
  const testing::Surface surface = testing::sphere(Eigen::Vector3d::Zero(), 50.0);
  std::vector<double> rms;
  for (const int size : {40, 80, 160}) {
    const MergeResult result = merged(views_around(surface, 8, size, 50.0));
    EXPECT_TRUE(result.check.watertight());
    EXPECT_EQ(result.check.genus, 0);
    EXPECT_EQ(result.check.components, 1u);
    EXPECT_EQ(result.components_removed, 0u);
    rms.push_back(measured_rms(result, sphere_distance(50.0)));
    EXPECT_LT(rms.back(), 0.01 * result.voxel_size);
    const double ball = 4.0 / 3.0 * std::numbers::pi * std::pow(50.0, 3);
    EXPECT_NEAR(result.check.volume / ball, 1.0, 2e-4 * result.voxel_size * result.voxel_size);
  }
  EXPECT_GT(rms[0] / rms[1], 3.8);
  EXPECT_GT(rms[1] / rms[2], 3.8);
}

// Of the views that see a place, the one that faces it counts most. Views without a pose count
// among those given.
TEST(MergeViews, VerticesKnowTheViewThatCountsMost) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 8, 60, 50.0);
  RangeView absent = views.front();
  absent.pose = PoseKind::kAbsent;
  views.insert(views.begin(), absent);
  const MergeResult result = merged(views);
  ASSERT_EQ(result.mesh.source_views.size(), result.mesh.vertices.size());
  std::size_t measured = 0, facing = 0;
  for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    const std::uint16_t source = result.mesh.source_views[v];
    EXPECT_EQ(source == kNoSourceView, result.mesh.filled[v] != 0);
    if (source == kNoSourceView) continue;
    ASSERT_GT(source, 0u);
    ASSERT_LT(source, views.size());
    const auto cosine = [&](const RangeView& view) {
      const Eigen::Vector3d away = view.world_from_view.translation() - result.mesh.vertices[v];
      return away.normalized().dot(result.mesh.vertices[v].normalized());
    };
    double best = -1.0;
    for (std::size_t i = 1; i < views.size(); ++i) best = std::max(best, cosine(views[i]));
    ++measured;
    facing += cosine(views[source]) > best - 0.15;
  }
  EXPECT_GT(measured, result.mesh.vertices.size() / 2);
  EXPECT_GT(static_cast<double>(facing), 0.95 * static_cast<double>(measured));
}

TEST(MergeViews, ATorusKeepsItsHole) {
  const SignedDistance torus = torus_distance(35.0, 12.0);
  const MergeResult result = merged(views_around(traced(torus), 14, 100, 50.0));
  EXPECT_TRUE(result.check.watertight());
  EXPECT_EQ(result.check.genus, 1);
  EXPECT_EQ(result.check.components, 1u);
  const double volume = 2.0 * std::pow(std::numbers::pi * 12.0, 2) * 35.0;
  EXPECT_NEAR(result.check.volume / volume, 1.0, 0.005);
  EXPECT_LT(measured_rms(result, torus), 0.03 * result.voxel_size);
}

TEST(MergeViews, ABoxKeepsItsFacesAndVolume) {
  const SignedDistance box = box_distance({30.0, 25.0, 20.0});
  const MergeResult result = merged(views_around(traced(box), 14, 100, 50.0));
  EXPECT_TRUE(result.check.watertight());
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_NEAR(result.check.volume / (60.0 * 50.0 * 40.0), 1.0, 0.01);
  EXPECT_LT(measured_rms(result, box), 0.12 * result.voxel_size);
}

TEST(MergeViews, AThinPlateKeepsItsThickness) {
  for (const double thickness : {4.0, 1.6}) {  // 5 and 2 voxels
    const SignedDistance plate = box_distance({30.0, 25.0, 0.5 * thickness});
    const MergeResult result = merged(views_around(traced(plate), 20, 120, 40.0));
    EXPECT_TRUE(result.check.watertight());
    EXPECT_EQ(result.check.genus, 0);
    EXPECT_NEAR(result.check.volume / (60.0 * 50.0 * thickness), 1.0, 0.025);
  }
}

TEST(MergeViews, AveragingManyViewsReducesNoise) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 20, 100, 50.0);
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.3, static_cast<std::uint32_t>(i));
  const MergeResult result = merged(views);
  EXPECT_TRUE(result.check.watertight());
  EXPECT_NEAR(result.view_noise, 0.2, 0.1);  // along the normal: below 0.3 at slanted samples
  const double rms = measured_rms(result, sphere_distance(50.0));
  EXPECT_LT(rms, 0.12);
  // The expected errors are of the size of the real ones.
  double expected = 0.0;
  for (const float quality : result.mesh.quality) expected += quality * quality;
  expected = std::sqrt(expected / static_cast<double>(result.mesh.quality.size()));
  EXPECT_GT(expected, 0.5 * rms);
  EXPECT_LT(expected, 2.0 * rms);
}

// Equal weights would take twice the error of the near views.
TEST(MergeViews, FarViewsDoNotSpoilNearOnes) {
  const auto views = testing::near_and_far_views(50.0, 0.15, 2.0);
  const MergeResult all = merged(views);
  const MergeResult near = merged({views.begin(), views.begin() + 12});
  EXPECT_GT(all.range_exponent, 1.5);
  const SignedDistance truth = sphere_distance(50.0);
  EXPECT_LT(measured_rms(all, truth), 1.1 * measured_rms(near, truth));
}

// Wrong calibration or poses: surfaces four voxels apart, each of them smooth.
TEST(MergeViews, ViewsThatDifferByVoxelsMakeOneSheet) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 20, 100, 50.0);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Vector3d axis = views[i].world_from_view.linear().col(2);
    views[i].world_from_view.pretranslate((i % 2 == 0 ? 2.0 : -2.0) * axis);
  }
  const MergeResult result = merged(views);
  EXPECT_TRUE(result.check.watertight());
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_EQ(result.components_removed, 0u);
  EXPECT_GT(result.inter_view_stddev, result.voxel_size);
  EXPECT_GT(result.truncation, 4.0 * result.inter_view_stddev);
  EXPECT_LT(measured_rms(result, sphere_distance(50.0)), 1.5);
}

TEST(MergeViews, RefinedViewsGetAFinerLattice) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 4, 40, 50.0);
  for (RangeView& view : views) view.deviation = Grid<float>(view.width(), view.height(), 0.1f);
  const double raw = merged(views).voxel_size;
  for (RangeView& view : views) view.samples = SampleOrigin::kRefined;
  EXPECT_DOUBLE_EQ(merged(views).voxel_size, 0.8 * raw);
}

TEST(MergeViews, OneViewIsClosedBehindWithoutEnteringSpaceSeenEmpty) {
  const auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 1, 80, 50.0);
  const MergeResult result = merged(views);
  EXPECT_TRUE(result.check.watertight());
  EXPECT_GT(result.filled_area_fraction, 0.3);
  const RangeView& view = views[0];
  std::size_t checked = 0;
  for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    if (!result.mesh.filled[v]) continue;
    const Eigen::Vector3d p = view.world_from_view.inverse() * result.mesh.vertices[v];
    const auto pixel = view.camera.project(p);
    if (!pixel) continue;
    const int u = static_cast<int>(std::lround(pixel->x())),
              w = static_cast<int>(std::lround(pixel->y()));
    if (!view.has_sample(u, w)) continue;
    const double in_front = view.normals(u, w).cast<double>().dot(p - view.point(u, w));
    EXPECT_LT(in_front, result.voxel_size);
    ++checked;
  }
  EXPECT_GT(checked, 100u);
}

// Two balls, seen from all sides.
std::vector<RangeView> two_balls(double first, double second) {
  return views_around(testing::traced([=](const Eigen::Vector3d& p) {
                        return std::min(p.norm() - first,
                                        (p - Eigen::Vector3d(0.0, 0.0, 60.0)).norm() - second);
                      }),
                      12, 90, 60.0);
}

TEST(MergeViews, KeepsAllPartsThatManySamplesLieOn) {
  const MergeResult result = merged(two_balls(30.0, 20.0), {});
  EXPECT_EQ(result.components_removed, 0u);
  EXPECT_EQ(result.check.components, 2u);
  EXPECT_THAT(result.notes, ::testing::Contains(::testing::HasSubstr("2 components, apart")));
}

TEST(MergeViews, TellsOfPartsThatItLeavesOut) {
  MergeOptions options;
  const MergeResult result = merged(two_balls(30.0, 6.0), options);
  EXPECT_EQ(result.components_removed, 1u);
  EXPECT_EQ(result.check.components, 1u);
  EXPECT_THAT(result.notes, ::testing::Contains(::testing::HasSubstr(
                                "% of the samples lie on 1 component that is left out")));
  options.keep_components = true;
  EXPECT_EQ(merged(two_balls(30.0, 6.0), options).check.components, 2u);
}

TEST(MergeViews, ViewsThatOthersContradictCountOnlyWhereNoOtherMeasured) {
  const SignedDistance torus = torus_distance(35.0, 12.0);
  std::vector<RangeView> views = views_around(traced(torus), 10, 80, 50.0);
  const double exact = measured_rms(merged(views), torus);
  views[3].world_from_view.pretranslate(
      Eigen::Vector3d(5.0 * views[3].world_from_view.linear().col(2)));
  const MergeResult result = merged(views);
  EXPECT_THAT(result.contradicted_views, ElementsAre(views[3].name));
  EXPECT_THAT(result.notes, ElementsAre(AllOf(StartsWith("view " + views[3].name + " contradicts"),
                                              HasSubstr("--keep-contradicted"))));
  EXPECT_LT(measured_rms(result, torus), 1.3 * exact);
  const MergeResult kept = merged(views, {.keep_contradicted = true});
  EXPECT_THAT(kept.contradicted_views, IsEmpty());
  EXPECT_THAT(kept.notes, IsEmpty());
  EXPECT_GT(measured_rms(kept, torus), 10.0 * exact);
}

// A plate without thickness: what views see of its sides is noise apart.
TEST(MergeViews, ManyHandlesThatAreTooSmallForAnObjectAreNoted) {
  std::vector<RangeView> views =
      views_around(traced(box_distance({30.0, 30.0, 0.1})), 12, 100, 45.0);
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.5, static_cast<std::uint32_t>(i));
  const MergeResult result = merged(views);
  EXPECT_GT(result.small_handles, 10u);
  EXPECT_LE(result.small_handles, static_cast<std::size_t>(result.check.genus));
  EXPECT_THAT(result.notes,
              ::testing::Contains(AllOf(StartsWith("of the "), HasSubstr("within eight voxels"),
                                        HasSubstr("thinner than two voxels"))));
  const MergeResult kept = merged(views, {.keep_handles = true});
  EXPECT_EQ(kept.handles_removed, 0u);
  EXPECT_EQ(result.check.genus, kept.check.genus - static_cast<long>(result.handles_removed));
  EXPECT_GT(result.handles_removed, 0u);
  EXPECT_TRUE(find_self_intersections(result.mesh, {}).faces().empty());
  EXPECT_THAT(result.notes, ::testing::Contains(HasSubstr("--keep-handles")));
}

// The large sheet is beyond all samples.
TEST(MergeViews, SamplesAndNotTheAreaTellWhichPartIsTheObject) {
  const auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 30.0), 4, 60, 50.0);
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) samplers.push_back(ViewSampler::create(view, {}).value());
  TriangleMesh mesh;
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(900, 0, 0), Eigen::Vector3d(0, 900, 0), Eigen::Vector3d(0, 0, 900)})
    mesh.vertices.push_back(corner);
  mesh.faces.push_back({0, 1, 2});
  const TriangleMesh ball = merged(views, {}).mesh;
  for (const auto& face : ball.faces) mesh.faces.push_back({face[0] + 3, face[1] + 3, face[2] + 3});
  mesh.vertices.insert(mesh.vertices.end(), ball.vertices.begin(), ball.vertices.end());
  const MeasuredComponents found = keep_measured_components(samplers, 4.0, mesh);
  EXPECT_EQ(found.kept, 1u);
  EXPECT_EQ(found.removed.components, 1u);
  EXPECT_EQ(found.removed_samples, 0.0);
  EXPECT_EQ(mesh.vertices, ball.vertices);
}

TEST(MergeViews, HolesCanBeKept) {
  const auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 2, 60, 50.0);
  MergeOptions options;
  options.keep_holes = true;
  const MergeResult result = merged(views, options);
  EXPECT_GT(result.check.boundary_edges, 0u);
  EXPECT_GT(result.filled_area_fraction, 0.0);
  for (const auto filled : result.mesh.filled) EXPECT_EQ(filled, 0);
  EXPECT_EQ(result.check.non_manifold_edges, 0u);
}

TEST(MergeViews, ThreadsAndTheOrderOfViewsDoNotChangeAByte) {
  auto views = views_around(traced(torus_distance(35.0, 12.0)), 6, 60, 50.0);
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.2, static_cast<std::uint32_t>(i));
  const auto merged_on = [&](int threads) {
    return on_threads(threads, [&] { return merged(views); });
  };
  const MergeResult reference = merged_on(1);
  for (const int threads : {2, 4})
    EXPECT_TRUE(same(merged_on(threads).mesh, reference.mesh)) << threads;
  std::reverse(views.begin(), views.end());
  TriangleMesh reversed = merged(views).mesh;
  const auto last = static_cast<std::uint16_t>(views.size() - 1);
  for (std::uint16_t& view : reversed.source_views)
    if (view <= last) view = static_cast<std::uint16_t>(last - view);
  EXPECT_TRUE(same(reversed, reference.mesh));
}

TEST(MergeViews, NothingDependsOnTheUnit) {
  auto views = views_around(traced(torus_distance(32.0, 12.0)), 6, 50, 50.0);
  const MergeResult large = merged(views);
  for (RangeView& view : views) {
    for (double& t : view.range) t /= 1024.0;
    view.world_from_view.translation() /= 1024.0;
  }
  const MergeResult small = merged(views);
  EXPECT_EQ(small.check.faces, large.check.faces);
  EXPECT_NEAR(small.check.volume * std::pow(1024.0, 3) / large.check.volume, 1.0, 1e-5);
}

TEST(MergeViews, AnOutlierSeenThroughByOthersIsRemoved) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 14, 60, 50.0);
  // A patch of one view floats 40 in front of the sphere.
  for (int v = 25; v < 35; ++v)
    for (int u = 25; u < 35; ++u) views[4].range(u, v) -= 20.0;
  const MergeResult result = merged(views);
  EXPECT_TRUE(result.check.watertight());
  for (const auto& p : result.mesh.vertices) EXPECT_LT(p.norm(), 53.0);
}

// A sample of what `relief_merge_scenes` in bench/ does with hundreds.
TEST(MergeViews, RandomScenesAreAlwaysClosedManifolds) {
  const testing::RandomScenes scenes;
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    const auto result = merge_views(scenes.scene(seed));
    ASSERT_THAT(result, IsOk()) << "seed " << seed;
    const MeshCheck check = check_mesh(result->mesh, {.self_intersections = true});
    EXPECT_TRUE(check.watertight()) << "seed " << seed;
    EXPECT_TRUE(check.self_intersections->pairs.empty()) << "seed " << seed;
  }
}

TEST(MergeViews, SaysWhatIsWrongWithItsInput) {
  EXPECT_THAT(merge_views({}), HasError(ErrorKind::kUnsolvable));
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 2, 40, 50.0);
  for (RangeView& view : views) view.pose = PoseKind::kAbsent;
  EXPECT_THAT(merge_views(views), HasError("align"));

  views[0].pose = PoseKind::kKnown;
  const MergeResult partly = merged(views);
  ASSERT_EQ(partly.notes.size(), 1u);
  EXPECT_NE(partly.notes[0].find("view1"), std::string::npos);

  for (RangeView& view : views) {
    view.pose = PoseKind::kKnown;
    for (double& t : view.range) t = kNoSample;
  }
  EXPECT_THAT(merge_views(views), HasError(ErrorKind::kUnsolvable));
}

TEST(MergeViews, NamesTheViewThatIsTooLargeForTheVoxels) {
  auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 5, 40, 50.0);
  views[3].name = "in micrometres";
  for (int v = 0; v < views[3].height(); ++v)
    for (int u = 0; u < views[3].width(); ++u) views[3].range(u, v) *= 1e5;
  EXPECT_THAT(merge_views(views), HasError(ErrorKind::kUnsolvable, "`in micrometres`, spans"));
}

TEST(MergeViews, CanBeInterrupted) {
  const auto views = views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 2, 40, 50.0);
  for (const double until : {0.0, 0.5, 0.87}) {
    const auto result = merge_views(views, {}, {.progress = [&](double fraction, std::string_view) {
                                      return fraction < until;
                                    }});
    EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
  }
}

}  // namespace
}  // namespace relief::fusion
