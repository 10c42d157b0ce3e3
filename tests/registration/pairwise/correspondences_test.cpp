#include "registration/pairwise/correspondences.h"

#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

struct Pair {
  std::vector<RangeView> views = testing::ring_of_views({.views = 8, .noise = 0.0});
  ViewSurface source{views[0], {.neighbour_index = true}};
  ViewSurface target{views[1], {.neighbour_index = true}};
  RigidMotion target_from_source = views[1].world_from_view.inverse() * views[0].world_from_view;

  CorrespondenceOptions options(Association association) const {
    CorrespondenceOptions search;
    search.count = 1000;
    search.max_distance = 5.0 * target.spacing();
    search.association = association;
    return search;
  }
};

const Pair& shared_pair() {
  static const Pair pair;
  return pair;
}

TEST(Correspondences, LieOnTheSameSurfaceAtTheTruePose) {
  const Pair& pair = shared_pair();
  for (const auto association : {Association::kProjective, Association::kNearest}) {
    const auto found = find_correspondences(pair.source, pair.target, pair.target_from_source,
                                            pair.options(association));
    EXPECT_GT(found.items.size(), 500u);
    // What is left is the error of linear interpolation.
    EXPECT_LT(rms_distance(found.items), 0.02 * pair.target.spacing());
  }
}

TEST(Correspondences, OfBothAssociationsAgree) {
  const Pair& pair = shared_pair();
  const RigidMotion guess = Eigen::Translation3d(0.5, -0.5, 0.8) * pair.target_from_source;
  const auto projective =
      find_correspondences(pair.source, pair.target, guess, pair.options(Association::kProjective));
  const auto nearest =
      find_correspondences(pair.source, pair.target, guess, pair.options(Association::kNearest));
  EXPECT_NEAR(projective.overlap(), nearest.overlap(), 0.03);
  EXPECT_NEAR(rms_distance(projective.items), rms_distance(nearest.items),
              0.05 * rms_distance(nearest.items));
}

TEST(Correspondences, RespectDistanceAndNormals) {
  const Pair& pair = shared_pair();
  auto options = pair.options(Association::kProjective);
  const RigidMotion far = Eigen::Translation3d(0, 0, 20.0) * pair.target_from_source;
  for (const auto& c : find_correspondences(pair.source, pair.target, far, options).items)
    EXPECT_LE((far * c.source.point - c.target.point).norm(), options.max_distance);
  options.max_normal_angle_deg = 10.0;
  const auto strict =
      find_correspondences(pair.source, pair.target, pair.target_from_source, options);
  for (const auto& c : strict.items)
    EXPECT_GE((pair.target_from_source.linear() * c.source.normal).dot(c.target.normal),
              std::cos(0.1746));
}

TEST(Correspondences, NeverPairTheTwoSidesOfAThinSheet) {
  const Camera camera = Camera::pinhole(60, 60, {100, 100, 29.5, 29.5});
  const auto sheet = testing::plane({0, 0, 0}, {0, 0, 1});
  const RangeView above =
      testing::render(sheet, camera, testing::look_at({0, 0, 10}, {0, 0, 0}, {0, 1, 0}));
  const RangeView below =
      testing::render(sheet, camera, testing::look_at({0, 0, -10}, {0, 0, 0}, {0, 1, 0}));
  const ViewSurface a(above), b(below);
  CorrespondenceOptions options;
  options.max_distance = 1.0;
  const RigidMotion b_from_a = below.world_from_view.inverse() * above.world_from_view;
  EXPECT_TRUE(find_correspondences(a, b, b_from_a, options).items.empty());
}

TEST(Correspondences, WeighByConfidence) {
  const Pair& pair = shared_pair();
  RangeView doubtful = pair.views[1];
  doubtful.confidence = Grid<float>(160, 160, 0.25f);
  const ViewSurface target(doubtful);
  const auto found = find_correspondences(pair.source, target, pair.target_from_source,
                                          pair.options(Association::kProjective));
  ASSERT_FALSE(found.items.empty());
  for (const auto& c : found.items) EXPECT_NEAR(c.weight, 0.25, 1e-6);
}

}  // namespace
}  // namespace relief::registration
