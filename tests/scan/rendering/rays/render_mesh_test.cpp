// Whole pictures against what is known of simple shapes.
#include "relief/rendering/render_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/scan/rendering/shapes.h"
#include "tests/support/result_matchers.h"

namespace relief::rendering {
namespace {

using testing::from_above;
using testing::plate;
using testing::sphere;

Picture picture_of(const TriangleMesh& mesh, const PictureCamera& camera, RenderStyle style,
                   const RenderOptions& options = {}) {
  return value_of(render_mesh(mesh, camera, style, options)).picture;
}

double opaque_pixels(const Picture& picture) {
  double sum = 0.0;
  for (const Rgba& pixel : picture) sum += pixel[3] / 255.0;
  return sum;
}

TEST(RenderMesh, TheSilhouetteOfASphereHasItsArea) {
  // The border crosses some 330 pixels, each with 16 samples: an error of a few pixels at most.
  const RenderOptions options{.antialiasing = 4, .background = Background::kTransparent};
  const Picture picture =
      picture_of(sphere(41.3), from_above(100, 90, 1.0), RenderStyle::kShaded, options);
  EXPECT_NEAR(opaque_pixels(picture), std::numbers::pi * 41.3 * 41.3, 8.0);
}

TEST(RenderMesh, APixelBesideASilhouetteIsCoveredAsFarAsTheSurfaceReaches) {
  // The plate ends at x = 2.25: pixel 2 reaches from 2 to 3, a quarter of it is covered.
  TriangleMesh mesh = plate(2.25);
  const PictureCamera camera = from_above(8, 8, 1.0);
  const Picture open = picture_of(mesh, camera, RenderStyle::kDepth,
                                  {.antialiasing = 4, .background = Background::kTransparent});
  EXPECT_EQ(open(5, 4)[3], 255);
  EXPECT_EQ(open(6, 4)[3], 64);
  EXPECT_EQ(open(6, 1)[3], 16);
  EXPECT_EQ(open(7, 4), kNothing);
  const Picture white = picture_of(mesh, camera, RenderStyle::kDepth, {.antialiasing = 4});
  EXPECT_EQ(white(7, 4), kOpaqueWhite);
  EXPECT_GT(white(6, 4)[2], white(5, 4)[2] + 100);
}

TEST(RenderMesh, TheDepthInTheMiddleIsTheDistanceToTheSphere) {
  // The camera is at z = 1000.
  const auto rendering =
      render_mesh(sphere(40.0), from_above(101, 101, 1.0), RenderStyle::kDepth, {.unit = "mm"});
  ASSERT_TRUE(rendering && rendering->legend);
  EXPECT_NEAR(rendering->legend->low, 960.0, 0.01);
  EXPECT_GT(rendering->legend->high, 990.0);
  EXPECT_LT(rendering->legend->high, 1000.0);
  EXPECT_EQ(rendering->legend->title, "range [mm]");
  const Rgba nearest = rendering->picture(50, 50);
  const Colour end = rendering->legend->bar.front();
  EXPECT_EQ((Colour{nearest[0], nearest[1], nearest[2]}), end);
}

TEST(RenderMesh, ValuesBeyondTheRangeHaveTheColoursOfTheEnds) {
  const auto rendering = render_mesh(plate(5.0), from_above(5, 5, 1.0), RenderStyle::kDepth,
                                     {.range = std::array{10.0, 20.0}});
  ASSERT_TRUE(rendering && rendering->legend);
  const Rgba far = rendering->picture(2, 2);
  EXPECT_EQ((Colour{far[0], far[1], far[2]}), rendering->legend->bar.back());
  EXPECT_EQ(rendering->legend->high, 20.0);
}

TEST(RenderMesh, NormalsOfASphereAreItsPlaces) {
  const double radius = 40.0;
  const Picture picture = picture_of(sphere(radius), from_above(101, 101, 1.0),
                                     RenderStyle::kNormals, {.antialiasing = 1});
  for (const auto& [x, y] : {std::pair{50, 50}, {70, 50}, {50, 30}, {30, 65}, {75, 75}}) {
    const Eigen::Vector2d place(x - 50.0, 50.0 - y);
    const Eigen::Vector3d normal(place.x() / radius, place.y() / radius,
                                 std::sqrt(1.0 - place.squaredNorm() / (radius * radius)));
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(picture(x, y)[static_cast<std::size_t>(k)], 127.5 * (normal[k] + 1.0), 1.6)
          << x << " " << y << " " << k;
  }
}

TEST(RenderMesh, NormalsAreThoseThatWereAskedFor) {
  TriangleMesh mesh = plate(5.0);
  mesh.normals.assign(4, Eigen::Vector3f(0.6f, 0.0f, 0.8f));
  const auto red = [&](ShadingNormals source) {
    return int{picture_of(mesh, from_above(3, 3, 1.0), RenderStyle::kNormals, {.normals = source})(
        1, 1)[0]};
  };
  EXPECT_NEAR(red(ShadingNormals::kOwn), 204, 1);
  EXPECT_NEAR(red(ShadingNormals::kGeometry), 128, 1);
  EXPECT_NEAR(red(ShadingNormals::kFaces), 128, 1);
}

TEST(RenderMesh, TheSmoothNormalsOfFacetsVaryInsideAFace) {
  const TriangleMesh ball = sphere(40.0, {0, 0, 0}, 3);
  const PictureCamera camera = from_above(201, 201, 0.5);
  const auto colours = [&](ShadingNormals source) {
    std::set<Rgba> all;
    for (const Rgba& pixel :
         picture_of(ball, camera, RenderStyle::kNormals, {.antialiasing = 1, .normals = source}))
      all.insert(pixel);
    return all.size();
  };
  EXPECT_LT(colours(ShadingNormals::kFaces), ball.faces.size());
  EXPECT_GT(colours(ShadingNormals::kGeometry), 10 * ball.faces.size());
}

TEST(RenderMesh, LightFollowsLambertsLaw) {
  // Light from the right at 60 degrees from the normal of the plate gives half of the light from
  // the front. The rest is the same for both.
  const auto brightness = [&](double azimuth) {
    const Picture picture = picture_of(plate(5.0), from_above(3, 3, 1.0), RenderStyle::kGrazing,
                                       {.light = LightDirection{azimuth, 0.0}});
    const double s = picture(1, 1)[0] / 255.0;
    return std::pow((s + 0.055) / 1.055, 2.4);
  };
  const double none = brightness(90.0);
  EXPECT_NEAR((brightness(60.0) - none) / (brightness(0.0) - none), 0.5, 0.01);
  EXPECT_LT(none, 0.06);
}

TEST(RenderMesh, LightFromTheRightIsBrightOnTheRight) {
  const Picture picture = picture_of(sphere(40.0), from_above(101, 101, 1.0), RenderStyle::kGrazing,
                                     {.light = LightDirection{60.0, 0.0}});
  EXPECT_GT(picture(75, 50)[0], picture(25, 50)[0] + 50);
  const Picture above = picture_of(sphere(40.0), from_above(101, 101, 1.0), RenderStyle::kGrazing,
                                   {.light = LightDirection{0.0, 60.0}});
  EXPECT_GT(above(50, 25)[0], above(50, 75)[0] + 50);
}

TEST(RenderMesh, BacksOfFacesHaveAnotherTint) {
  TriangleMesh mesh = plate(5.0);
  const Rgba front = picture_of(mesh, from_above(3, 3, 1.0), RenderStyle::kShaded)(1, 1);
  for (auto& face : mesh.faces) std::swap(face[0], face[1]);
  const Rgba back = picture_of(mesh, from_above(3, 3, 1.0), RenderStyle::kShaded)(1, 1);
  EXPECT_LT(front[0] - front[2], 20);  // grey
  EXPECT_GT(back[0] - back[2], 50);    // brown
}

TEST(RenderMesh, HidesWhatIsBehind) {
  TriangleMesh mesh = plate(5.0);
  const TriangleMesh ball = sphere(2.0, {0, 0, -4.0}, 10);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), ball.vertices.begin(), ball.vertices.end());
  for (const auto& face : ball.faces)
    mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
  const auto rendering =
      render_mesh(mesh, from_above(9, 9, 1.0), RenderStyle::kDepth, {.antialiasing = 1});
  ASSERT_TRUE(rendering && rendering->legend);
  EXPECT_NEAR(rendering->legend->low, 1000.0, 1e-3);
  EXPECT_NEAR(rendering->legend->high, 1000.0, 1e-3);
}

TEST(RenderMesh, AccessibilityIsFullOnAPlateAndHalfInACorner) {
  const PictureCamera camera = from_above(21, 21, 1.0);
  const RenderOptions options{.ambient_rays = 1024, .ambient_reach = 10.0};
  // Light is in proportion to the power 2.2 of what is open.
  const auto open_share = [](const Rgba& pixel) {
    return std::pow((pixel[0] / 255.0 + 0.055) / 1.055, 2.4 / 2.2);
  };
  const Picture open = picture_of(plate(1000.0), camera, RenderStyle::kAccessibility, options);
  const Picture corner =
      picture_of(testing::floor_and_wall(1000.0), camera, RenderStyle::kAccessibility, options);
  EXPECT_EQ(open(3, 3), open(17, 12));
  // Row 11 is one pixel in front of the wall, where almost half of the sky is hidden.
  for (int x = 0; x < 21; ++x)
    EXPECT_NEAR(open_share(corner(x, 11)) / open_share(open(x, 11)), 0.5,
                5.0 * 0.5 / std::sqrt(1024.0));
}

TEST(RenderMesh, GivesTheSameBytesOnAnyNumberOfThreads) {
  const TriangleMesh mesh = sphere(40.0, {10, 20, 30}, 40);
  const PictureCamera camera = frame_mesh(mesh, {}, {.width = 90, .height = 70});
  for (const RenderStyle style :
       {RenderStyle::kShaded, RenderStyle::kDepth, RenderStyle::kAccessibility}) {
    const auto picture_on = [&](int threads) {
      return on_threads(threads,
                        [&] { return picture_of(mesh, camera, style, {.ambient_rays = 16}); });
    };
    const Picture one = picture_on(1), two = picture_on(2);
    EXPECT_TRUE(std::equal(one.begin(), one.end(), two.begin())) << to_string(style);
  }
}

TEST(RenderMesh, ADifferentSeedChangesTheRandomRaysOnly) {
  const TriangleMesh mesh = testing::floor_and_wall(10.0);
  const PictureCamera camera = from_above(20, 20, 1.0);
  const auto differs = [&](RenderStyle style) {
    const Picture a = picture_of(mesh, camera, style, {.ambient_rays = 16, .seed = 1});
    const Picture b = picture_of(mesh, camera, style, {.ambient_rays = 16, .seed = 2});
    return !std::equal(a.begin(), a.end(), b.begin());
  };
  EXPECT_TRUE(differs(RenderStyle::kAccessibility));
  EXPECT_FALSE(differs(RenderStyle::kShaded));
}

TEST(RenderMesh, AnEmptyMeshIsAnError) {
  EXPECT_THAT(render_mesh({}, from_above(3, 3, 1.0), RenderStyle::kShaded),
              HasError(ErrorKind::kBadInput, "no faces"));
}

}  // namespace
}  // namespace relief::rendering
