#include "scan/io/normals/convention_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/normals/normal_map.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::kDegree;
const Camera kCamera = Camera::pinhole(150, 150, {300, 300, 74.5, 74.5});
const Eigen::Matrix3d kIdentity = Eigen::Matrix3d::Identity();
const Eigen::Matrix3d kYReversed = Eigen::Vector3d(1, -1, 1).asDiagonal();

// A height field over the plane z = 100, seen along z from the origin: slopes in x and y differ.
double waves(double x, double y, double slope) {
  const double k = 0.3;
  return slope / k *
         (std::sin(k * x) + 0.5 * std::cos(0.8 * k * y + 1.0) + 0.4 * std::sin(k * (x - 1.3 * y)));
}

// The plane of tilt (a, b) at distance 100 with waves of about the given slope, as seen by kCamera.
RangeView wavy_view(double slope, double a = 0.0, double b = 0.0) {
  RangeView view = testing::render(testing::plane({0, 0, 100}, {a, b, -1}), kCamera);
  const auto height = [&](double x, double y) {
    return 100.0 + a * x + b * y + waves(x, y, slope);
  };
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const Eigen::Vector3d d = view.camera.ray(u, v).direction;
      double z = 100.0;
      for (int i = 0; i < 60; ++i) z = height(d.x() * z, d.y() * z);
      view.range(u, v) = z;
      const double x = d.x() * z, y = d.y() * z, e = 1e-4;
      const Eigen::Vector3d n((height(x + e, y) - height(x - e, y)) / (2 * e),
                              (height(x, y + e) - height(x, y - e)) / (2 * e), -1.0);
      view.normals(u, v) = n.normalized().cast<float>();
    }
  }
  return view;
}

RangeView sphere_view() { return testing::render(testing::sphere({0, 0, 100}, 20), kCamera); }

// Turns all normals by a rotation of `angle` [rad] about an axis that itself changes slowly.
void add_bias(RangeView& view, double angle) {
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      const double phase = 0.02 * u + 0.013 * v;
      const Eigen::Vector3d axis(std::cos(phase), std::sin(phase), 0.0);
      view.normals(u, v) =
          (Eigen::AngleAxisd(angle, axis) * view.normals(u, v).cast<double>()).cast<float>();
    }
}

const NormalSpec kDeclared{"n.tiff", NormalEncoding::kUnit, NormalAxes::kOpencv,
                           NormalSpace::kCamera};

// The normals of `view` stored as `stored_from_view` says.
StoredNormals store(const RangeView& view, const Eigen::Matrix3d& stored_from_view,
                    const NormalSpec& spec = kDeclared) {
  Image image(view.width(), view.height(), 3);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_normal(u, v))
        for (int c = 0; c < 3; ++c)
          image(u, v, c) =
              static_cast<float>((stored_from_view * view.normals(u, v).cast<double>())[c]);
  return stored_in_image(image, spec, view).value();
}

// The mean angle between the normals that are found and the view's own [rad].
double error_after(const RangeView& view, const StoredNormals& stored,
                   const ChosenConvention& chosen) {
  RangeView found = view;
  apply_convention(stored, chosen, found);
  if (!found.has_normals()) return std::numbers::pi;
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < view.normals.size(); ++i) {
    if (!found.normals[i].allFinite() || !view.normals[i].allFinite()) continue;
    sum += (found.normals[i] - view.normals[i]).norm();
    count += 1.0;
  }
  return sum / count;
}

TEST(ConventionChoice, EveryFlipAndSwapUnderAWrongDeclarationIsFound) {
  RangeView view = sphere_view();
  testing::add_range_noise(view, 0.3 / 3.0, 7);
  add_bias(view, 4.0 * kDegree);
  for (const NormalConvention& convention : all_conventions(NormalFileKind::kImage)) {
    if (convention.space == NormalSpace::kWorld) continue;
    const StoredNormals stored = store(view, convention.space_from_stored.transpose());
    const auto choice = value_of(choose_conventions({stored.evidence}));
    EXPECT_LT(error_after(view, stored, choice.views[0]), 1e-5)
        << to_string(convention, NormalFileKind::kImage);
    if (convention == NormalConvention{}) {
      EXPECT_TRUE(choice.notes.empty()) << choice.notes.front();
    } else {
      ASSERT_EQ(choice.notes.size(), 1u);
      EXPECT_THAT(choice.notes[0], HasSubstr("axes opencv, space camera as declared"));
      EXPECT_THAT(choice.notes[0], HasSubstr(to_string(convention, NormalFileKind::kImage)));
    }
  }
}

TEST(ConventionChoice, WorldSpaceUnderADeclarationOfCameraSpaceIsFound) {
  RangeView view = testing::render(testing::sphere({0, 0, 0}, 20), kCamera,
                                   testing::look_at({70, 50, 40}, {0, 0, 0}));
  const StoredNormals stored = store(view, view.world_from_view.linear());
  const auto choice = value_of(choose_conventions({stored.evidence}));
  EXPECT_LT(error_after(view, stored, choice.views[0]), 1e-5);
  EXPECT_THAT(choice.notes.at(0), HasSubstr("space world"));
}

TEST(ConventionChoice, BiasWithinThatOfPhotometricStereoKeepsTheDeclaration) {
  for (const double bias : {4.0, 10.0, 14.0}) {
    RangeView view = sphere_view();
    testing::add_range_noise(view, 0.1, 7);
    add_bias(view, bias * kDegree);
    const auto choice = value_of(choose_conventions({store(view, kIdentity).evidence}));
    EXPECT_TRUE(choice.notes.empty()) << bias << ": " << choice.notes.front();
    EXPECT_TRUE(choice.views[0].usable);
  }
}

TEST(ConventionChoice, NoiseFarAboveTheSpacingIsNoEvidence) {
  RangeView view = wavy_view(0.1);
  testing::add_range_noise(view, 30.0, 3);
  const auto choice = value_of(choose_conventions({store(view, kIdentity).evidence}));
  EXPECT_EQ(choice.views[0].convention, NormalConvention{});
  EXPECT_TRUE(choice.views[0].usable);
  EXPECT_THAT(choice.notes.at(0), HasSubstr("other conventions fit as well"));
}

TEST(ConventionChoice, QuantisedRangesStillTell) {
  RangeView view = sphere_view();
  for (double& t : view.range) t = std::round(t / 1.3) * 1.3;  // Four spacings.
  const StoredNormals stored = store(view, kYReversed);
  const auto choice = value_of(choose_conventions({stored.evidence}));
  EXPECT_LT(error_after(view, stored, choice.views[0]), 1e-5);
}

TEST(ConventionChoice, AFrontalPlateIsUndecidedAndKeepsTheDeclaration) {
  // A bias of the tilt's size turns it the other way: another convention would seem to fit exactly.
  RangeView view = wavy_view(0.0, 5.0 * kDegree);
  testing::add_range_noise(view, 0.1, 3);
  const Eigen::AngleAxisd bias(10.0 * kDegree, Eigen::Vector3d::UnitY());
  for (auto& normal : view.normals) normal = (bias * normal.cast<double>()).cast<float>();
  const auto choice = value_of(choose_conventions({store(view, kIdentity).evidence}));
  EXPECT_EQ(choice.views[0].convention, NormalConvention{});
  ASSERT_EQ(choice.notes.size(), 1u);
  EXPECT_THAT(choice.notes[0], HasSubstr("taken as declared"));
  EXPECT_THAT(choice.notes[0], HasSubstr("other conventions fit as well"));
}

TEST(ConventionChoice, LowReliefDecidesInSpiteOfALargerBias) {
  RangeView view = wavy_view(4.0 * kDegree);
  testing::add_range_noise(view, 0.05, 3);
  add_bias(view, 10.0 * kDegree);
  for (const Eigen::Matrix3d& stored_from_view : {kIdentity, kYReversed}) {
    const StoredNormals stored = store(view, stored_from_view);
    const auto choice = value_of(choose_conventions({stored.evidence}));
    EXPECT_LT(error_after(view, stored, choice.views[0]), 1e-5);
    EXPECT_EQ(choice.notes.empty(), stored_from_view == kIdentity);
  }
}

TEST(ConventionChoice, AViewThatCannotTellFollowsTheOthers) {
  RangeView flat = wavy_view(0.0);
  flat.name = "flat";
  testing::add_range_noise(flat, 0.1, 3);
  const RangeView sphere = sphere_view();
  const auto choice = value_of(
      choose_conventions({store(flat, kYReversed).evidence, store(sphere, kYReversed).evidence}));
  for (const ChosenConvention& chosen : choice.views)
    EXPECT_EQ(chosen.convention.space_from_stored, kYReversed);
  ASSERT_EQ(choice.notes.size(), 1u);
  EXPECT_THAT(choice.notes[0], HasSubstr("views flat, synthetic:"));
}

TEST(ConventionChoice, AViewThatDiffersFromTheOthersIsCorrectedAlone) {
  const RangeView view = sphere_view();
  const auto choice = value_of(
      choose_conventions({store(view, kIdentity).evidence, store(view, kYReversed).evidence,
                          store(view, kIdentity).evidence}));
  EXPECT_EQ(choice.views[0].convention, NormalConvention{});
  EXPECT_EQ(choice.views[1].convention.space_from_stored, kYReversed);
  EXPECT_EQ(choice.views[2].convention, NormalConvention{});
}

// A sphere so small that its patches alone are too few to tell conventions apart.
RangeView small_sphere_view() {
  RangeView view = testing::render(testing::sphere({0, 0, 100}, 7), kCamera);
  view.name = "small";
  return view;
}

TEST(ConventionChoice, ASmallViewOfAMixedSetFollowsItsOwnDepth) {
  const NormalSpec undeclared{"n.tiff", NormalEncoding::kUnit, {}, {}};
  const Eigen::Matrix3d opengl = Eigen::Vector3d(1, -1, -1).asDiagonal();
  RangeView view = sphere_view(), other = view;
  view.name = "opencv";
  other.name = "opengl";
  for (const Eigen::Matrix3d& of_small : {kIdentity, opengl}) {
    const auto choice = value_of(choose_conventions(
        {store(small_sphere_view(), of_small, undeclared).evidence,
         store(other, opengl, undeclared).evidence, store(view, kIdentity, undeclared).evidence,
         store(other, opengl, undeclared).evidence, store(view, kIdentity, undeclared).evidence}));
    EXPECT_EQ(choice.views[0].convention.space_from_stored, of_small);
    EXPECT_EQ(choice.views[1].convention.space_from_stored, opengl);
    EXPECT_EQ(choice.views[2].convention.space_from_stored, kIdentity);
    ASSERT_EQ(choice.notes.size(), 3u);
    EXPECT_THAT(choice.notes.back(), HasSubstr("not all normals are of one convention"));
    EXPECT_THAT(choice.notes.back(), HasSubstr("those of 2 of 5 views"));
  }
}

TEST(ConventionChoice, AViewThatCannotTellFollowsTheMostOfAMixedSet) {
  RangeView flat = wavy_view(0.0, 0.0, 5.0 * kDegree);
  testing::add_range_noise(flat, 0.1, 3);
  const RangeView sphere = sphere_view();
  const auto choice = value_of(
      choose_conventions({store(sphere, kIdentity).evidence, store(flat, kYReversed).evidence,
                          store(sphere, kYReversed).evidence, store(sphere, kYReversed).evidence}));
  EXPECT_EQ(choice.views[0].convention, NormalConvention{});
  for (const std::size_t i : {1, 2, 3})
    EXPECT_EQ(choice.views[i].convention.space_from_stored, kYReversed) << i;
  EXPECT_THAT(choice.notes, ::testing::Contains(HasSubstr("but other conventions fit as well")));
}

TEST(ConventionChoice, NormalsWithALargeBiasAreNotUsed) {
  RangeView view = sphere_view();
  testing::add_range_noise(view, 0.1, 7);
  add_bias(view, 22.0 * kDegree);
  const StoredNormals stored = store(view, kIdentity);
  const auto choice = value_of(choose_conventions({stored.evidence}));
  EXPECT_FALSE(choice.views[0].usable);
  ASSERT_EQ(choice.notes.size(), 1u);
  EXPECT_THAT(choice.notes[0], HasSubstr("normals are not used"));
  EXPECT_THAT(choice.notes[0], HasSubstr("15.0 deg"));
  apply_convention(stored, choice.views[0], view);
  EXPECT_FALSE(view.has_normals());
}

TEST(ConventionChoice, AnImageOfSomethingElseIsAnError) {
  const RangeView view = sphere_view();
  RangeView other = view;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      other.normals(u, v) = Eigen::Vector3d(0.9 * std::sin(0.15 * u), 0.9 * std::cos(0.2 * v), -0.5)
                                .normalized()
                                .cast<float>();
  EXPECT_THAT(choose_conventions({store(other, kIdentity).evidence}),
              HasError(ErrorKind::kBadInput, "n.tiff: no convention of normals fits",
                       "belongs to this view"));
}

TEST(ConventionChoice, AMapOfAnotherViewIsLeftOutAndNamed) {
  RangeView sphere = sphere_view(), slope = wavy_view(0.2, 1.5), mixed_up = sphere;
  sphere.name = "sphere";
  slope.name = "slope";
  mixed_up.name = "mixed up";
  for (std::size_t i = 0; i < sphere.normals.size(); ++i)
    if (sphere.normals[i].allFinite()) mixed_up.normals[i] = slope.normals[i];
  const StoredNormals of_sphere = store(sphere, kIdentity), of_slope = store(slope, kIdentity),
                      of_other = store(mixed_up, kIdentity);
  const auto choice =
      value_of(choose_conventions({of_sphere.evidence, of_other.evidence, of_slope.evidence}));
  EXPECT_TRUE(choice.views[0].usable);
  EXPECT_FALSE(choice.views[1].usable);
  EXPECT_TRUE(choice.views[2].usable);
  ASSERT_FALSE(choice.notes.empty());
  EXPECT_THAT(choice.notes.back(), HasSubstr("1 of 3 normal maps is not used"));
  EXPECT_THAT(choice.notes.back(), HasSubstr("n.tiff of view mixed up"));
  EXPECT_THAT(choice.notes.back(), HasSubstr("fits the depth of view slope"));
  EXPECT_THAT(
      choose_conventions({of_sphere.evidence, of_other.evidence, of_other.evidence}),
      HasError(ErrorKind::kBadInput, "no convention of normals fits the depth of view mixed up",
               "2 of 3 maps are as far off"));
}

TEST(ConventionChoice, ExchangedMapsNameEachOther) {
  RangeView first = sphere_view(), second = wavy_view(0.2, 1.5);
  first.name = "first";
  second.name = "second";
  std::swap(first.normals, second.normals);
  const auto evidence = [](const RangeView& view) { return store(view, kYReversed).evidence; };
  const auto choice = value_of(
      choose_conventions({evidence(first), evidence(second), evidence(wavy_view(0.4, 0.7, -0.2)),
                          evidence(wavy_view(0.4, -0.6, 0.9))}));
  EXPECT_FALSE(choice.views[0].usable);
  EXPECT_FALSE(choice.views[1].usable);
  EXPECT_THAT(choice.notes.back(), HasSubstr("2 of 4 normal maps are not used"));
  EXPECT_THAT(choice.notes.back(), HasSubstr("fits the depth of view second"));
  EXPECT_THAT(choice.notes.back(), HasSubstr("fits the depth of view first"));
}

// The view whose map has at pixel (u, v) what belongs to `from(u, v)`.
template <typename From>
RangeView with_map_from(RangeView view, const From& from) {
  const auto right = view.normals;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const Eigen::Vector2i pixel = from(u, v);
      if (right.contains(pixel.x(), pixel.y()))
        view.normals(u, v) = right(pixel.x(), pixel.y());
      else
        view.normals(u, v).setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }
  return view;
}

TEST(ConventionChoice, AMapThatLiesWrongIsLeftOutAndItsPlaceNamed) {
  const RangeView view = wavy_view(0.4);
  const auto note = [&](const auto& from) {
    const StoredNormals right = store(view, kYReversed),
                        wrong = store(with_map_from(view, from), kYReversed);
    const auto choice = value_of(choose_conventions({right.evidence, wrong.evidence}));
    EXPECT_TRUE(choice.views[0].usable);
    EXPECT_FALSE(choice.views[1].usable);
    return choice.notes.back();
  };
  using Pixel = Eigen::Vector2i;
  EXPECT_THAT(note([](int u, int v) { return Pixel(u - 8, v); }),
              HasSubstr("but fits it moved by 8 pixels to the left, to "));
  EXPECT_THAT(note([](int u, int v) { return Pixel(u + 9, v - 12); }),
              HasSubstr("but fits it moved by 9 pixels to the right and 12 pixels up, to "));
  EXPECT_THAT(note([](int u, int v) { return Pixel(149 - u, v); }),
              HasSubstr("but fits it mirrored left to right, to "));
  EXPECT_THAT(note([](int u, int v) { return Pixel(u, 149 - v); }),
              HasSubstr("but fits it mirrored top to bottom, to "));
  EXPECT_THAT(note([](int u, int v) { return Pixel(149 - u, 149 - v); }),
              HasSubstr("but fits it turned by 180 deg, to "));
}

TEST(ConventionChoice, ABiasThatAMoveWouldCancelIsNoWrongPlace) {
  RangeView view = sphere_view();
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.normals(u, v) =
          Eigen::AngleAxisf(static_cast<float>(12.0 * kDegree), Eigen::Vector3f::UnitY()) *
          view.normals(u, v);
  EXPECT_FALSE(store(view, kIdentity).evidence.placement);
}

TEST(ConventionChoice, NormalsBesideACoarseDepthThatWasEnlargedAreUsed) {
  RangeView view = wavy_view(0.5, 0.3);
  const auto fine = view.range;
  constexpr int kBlock = 8;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.range(u, v) = fine(std::min(u / kBlock * kBlock + kBlock / 2, view.width() - 1),
                              std::min(v / kBlock * kBlock + kBlock / 2, view.height() - 1));
  EXPECT_TRUE(value_of(choose_conventions({store(view, kIdentity).evidence})).views[0].usable);
}

TEST(ConventionChoice, NotesNameSomeOfManyViews) {
  const RangeView view = wavy_view(0.4);
  const NormalEvidence right = store(view, kIdentity).evidence,
                       reversed = store(view, kYReversed).evidence;
  std::vector<NormalEvidence> views;
  for (int i = 0; i < 24; ++i) {
    views.push_back(i % 2 ? reversed : right);
    views.back().view = "v" + std::to_string(i);
  }
  EXPECT_THAT(value_of(choose_conventions(views)).notes,
              Contains(HasSubstr("views v1, v3, v5, v7, v9, v11, v13, v15 and 4 more: ")));
}

TEST(ConventionChoice, NormalsInGridFilesAreCorrectedToo) {
  const RangeView view = sphere_view();
  Eigen::Matrix3d swapped;
  swapped << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d z_reversed = Eigen::Vector3d(1, 1, -1).asDiagonal();
  for (const Eigen::Matrix3d& stored_from_view : {kIdentity, kYReversed, z_reversed, swapped}) {
    Grid<Eigen::Vector3f> components = view.normals;
    for (auto& normal : components)
      normal = (stored_from_view * normal.cast<double>()).cast<float>();
    const StoredNormals stored = stored_in_grid(components, "scan.ply", view);
    const auto choice = value_of(choose_conventions({stored.evidence}));
    EXPECT_LT(error_after(view, stored, choice.views[0]), 1e-5);
    EXPECT_EQ(choice.notes.empty(), stored_from_view == kIdentity);
  }
}

}  // namespace
}  // namespace relief
