#include "scan/io/normals/normal_map.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using ::testing::HasSubstr;

class NormalMaps : public ::testing::Test {
 protected:
  // A bumpy plane would do as well; a sphere has normals in all directions.
  void SetUp() override {
    view_ =
        testing::render(testing::sphere({1, 2, 12}, 3), Camera::pinhole(60, 50, {70, 70, 25, 20}),
                        testing::look_at({9, 3, 4}, {0, 0, 0}));
    if (view_.sample_count() == 0) {
      view_ = testing::render(testing::sphere({0, 0, 0}, 3),
                              Camera::pinhole(60, 50, {70, 70, 29.5, 24.5}),
                              testing::look_at({9, 3, 4}, {0, 0, 0}));
    }
    truth_ = view_.normals;
    view_.normals = {};
  }

  Image encode(const Eigen::Matrix3d& image_from_view, bool rgb) const {
    Image image(view_.width(), view_.height(), 3, rgb ? 65535 : 0);
    for (int v = 0; v < view_.height(); ++v) {
      for (int u = 0; u < view_.width(); ++u) {
        if (!truth_(u, v).allFinite()) continue;
        const Eigen::Vector3d n = image_from_view * truth_(u, v).cast<double>();
        for (int c = 0; c < 3; ++c)
          image(u, v, c) = rgb ? std::round(static_cast<float>((n[c] + 1.0) / 2.0 * 65535.0))
                               : static_cast<float>(n[c]);
      }
    }
    return image;
  }

  struct Decoded {
    Grid<Eigen::Vector3f> normals;
    std::vector<std::string> notes;
  };

  // Reads an image and settles its convention for this view alone.
  Result<Decoded> decode_normals(const Image& image, const NormalSpec& spec,
                                 const RangeView& view) const {
    const auto stored = stored_in_image(image, spec, view);
    if (!stored) return stored.error();
    const auto choice = choose_conventions({stored->evidence});
    if (!choice) return choice.error();
    RangeView decoded = view;
    Decoded result{{}, choice->notes};
    const auto dropped = apply_convention(*stored, choice->views.front(), decoded);
    result.notes.insert(result.notes.end(), dropped.begin(), dropped.end());
    result.normals = decoded.normals;
    return result;
  }

  double largest_difference(const Grid<Eigen::Vector3f>& normals) const {
    double largest = 0.0;
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (truth_[i].allFinite())
        largest = std::max(largest, static_cast<double>((normals[i] - truth_[i]).norm()));
    return largest;
  }

  RangeView view_;
  Grid<Eigen::Vector3f> truth_;
};

const Eigen::Matrix3d kGl = Eigen::Vector3d(1, -1, -1).asDiagonal();

TEST_F(NormalMaps, DecodesDeclaredConventions) {
  const Eigen::Matrix3d world = view_.world_from_view.linear();
  const struct {
    Eigen::Matrix3d image_from_view;
    NormalAxes axes;
    NormalSpace space;
  } cases[] = {{Eigen::Matrix3d::Identity(), NormalAxes::kOpencv, NormalSpace::kCamera},
               {kGl, NormalAxes::kOpengl, NormalSpace::kCamera},
               {world, NormalAxes::kOpencv, NormalSpace::kWorld},
               {kGl * world, NormalAxes::kOpengl, NormalSpace::kWorld}};
  for (const auto& c : cases) {
    for (const bool rgb : {false, true}) {
      const NormalSpec spec{"n", rgb ? NormalEncoding::kRgb : NormalEncoding::kUnit, c.axes,
                            c.space};
      const auto map = value_of(decode_normals(encode(c.image_from_view, rgb), spec, view_));
      EXPECT_LT(largest_difference(map.normals), rgb ? 1e-4 : 1e-6);
      EXPECT_TRUE(map.notes.empty()) << map.notes.front();
    }
  }
}

TEST_F(NormalMaps, FindsWhatIsNotDeclaredAndNamesIt) {
  for (const bool gl : {false, true}) {
    for (const bool rgb : {false, true}) {
      const auto map =
          value_of(decode_normals(encode(gl ? kGl : Eigen::Matrix3d::Identity().eval(), rgb),
                                  NormalSpec{"n", {}, {}, {}}, view_));
      EXPECT_LT(largest_difference(map.normals), 1e-4);
      ASSERT_EQ(map.notes.size(), 1u);
      EXPECT_THAT(map.notes[0], HasSubstr(gl ? "opengl" : "opencv"));
      EXPECT_THAT(map.notes[0], HasSubstr(rgb ? "rgb" : "unit"));
      EXPECT_THAT(map.notes[0], HasSubstr("camera"));
    }
  }
  const auto world = value_of(decode_normals(encode(view_.world_from_view.linear(), false),
                                             NormalSpec{"n", {}, {}, {}}, view_));
  EXPECT_THAT(world.notes.at(0), HasSubstr("world"));
}

// An image whose values went through `curve`, from 0 to 1, and were rounded to 8 bits.
Image through_curve(Image image, double (*curve)(double)) {
  for (float& value : image.samples)
    value = static_cast<float>(std::round(255.0 * curve(value / image.max_value)));
  image.max_value = 255.0;
  return image;
}

TEST_F(NormalMaps, UndoesTheGammaOfColoursAndSaysSo) {
  const NormalSpec spec{"n", NormalEncoding::kRgb, NormalAxes::kOpengl, NormalSpace::kCamera};
  const struct {
    double (*curve)(double);
    const char* note;
    double largest;
  } cases[] = {
      {[](double x) { return std::pow(x, 1.0 / 2.2); }, "with the gamma of colours (2.2)", 0.02},
      {[](double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055; },
       "with the gamma of colours (sRGB)", 0.02},
      // Dark values, as of components near -1, are lost to rounding.
      {[](double x) { return std::pow(x, 2.2); }, "without their gamma (2.2)", 0.12}};
  for (const auto& [curve, note, largest] : cases) {
    const auto map = value_of(decode_normals(through_curve(encode(kGl, true), curve), spec, view_));
    EXPECT_LT(largest_difference(map.normals), largest) << note;
    ASSERT_EQ(map.notes.size(), 1u) << note;
    EXPECT_THAT(map.notes[0], HasSubstr(note));
  }
}

TEST_F(NormalMaps, ShortenedNormalsHaveNoGamma) {
  for (auto& normal : truth_) normal *= 0.85f;
  const auto map = value_of(decode_normals(
      encode(kGl, true), {"n", NormalEncoding::kRgb, NormalAxes::kOpengl, NormalSpace::kCamera},
      view_));
  EXPECT_TRUE(map.notes.empty()) << map.notes.front();
}

TEST_F(NormalMaps, IsAnErrorWhenNothingFits) {
  Eigen::Matrix3d swapped;
  swapped << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  view_.pose = PoseKind::kAbsent;
  EXPECT_THAT(decode_normals(encode(swapped, false), NormalSpec{"bad.tiff", {}, {}, {}}, view_),
              HasError("bad.tiff", "no convention"));
}

TEST_F(NormalMaps, AWrongDeclarationIsCorrectedAndNamed) {
  const auto map = value_of(decode_normals(
      encode(kGl, false),
      NormalSpec{"n", NormalEncoding::kUnit, NormalAxes::kOpencv, NormalSpace::kCamera}, view_));
  EXPECT_LT(largest_difference(map.normals), 1e-6);
  ASSERT_FALSE(map.notes.empty());
  EXPECT_THAT(map.notes[0], HasSubstr("warning"));
  EXPECT_THAT(map.notes[0], HasSubstr("opencv"));
  EXPECT_THAT(map.notes[0], HasSubstr("opengl"));
  EXPECT_THAT(map.notes[0], HasSubstr(view_.name));
}

TEST_F(NormalMaps, PixelsWithoutADirectionGetNone) {
  Image image = encode(Eigen::Matrix3d::Identity(), false);
  int u = 0, v = 0;
  for (; !view_.has_sample(u, v); u == view_.width() - 1 ? (u = 0, ++v) : ++u) {
  }
  for (int c = 0; c < 3; ++c) image(u, v, c) *= 0.3f;
  const auto map = value_of(decode_normals(
      image, NormalSpec{"n", NormalEncoding::kUnit, NormalAxes::kOpencv, NormalSpace::kCamera},
      view_));
  EXPECT_FALSE(map.normals(u, v).allFinite());
  ASSERT_EQ(map.notes.size(), 1u);
  EXPECT_THAT(map.notes[0], HasSubstr("1 of"));
}

TEST_F(NormalMaps, NeedsThreeChannelsAndAPoseForWorldSpace) {
  EXPECT_THAT(decode_normals(Image(60, 50, 1), NormalSpec{"n", {}, {}, {}}, view_), HasError());
  view_.pose = PoseKind::kAbsent;
  EXPECT_THAT(decode_normals(Image(60, 50, 3), NormalSpec{"n", {}, {}, NormalSpace::kWorld}, view_),
              HasError());
}

TEST(SensorAxes, FollowTheGridOfEveryModel) {
  EXPECT_TRUE(sensor_axes(Camera::pinhole(4, 4, {5, 5, 2, 2})).isIdentity());
  const Eigen::Matrix3d gl = sensor_axes(Camera::pinhole_gl(4, 4, {5, 5, 2, 2}));
  EXPECT_TRUE(gl.isApprox(Eigen::Matrix3d(Eigen::Vector3d(1, 1, -1).asDiagonal())));
  const Eigen::Matrix3d parallel = sensor_axes(Camera::orthographic(
      4, 4, {0, 0, 0}, {0, 0.1, 0}, {0.1, 0, 0.02}, -Eigen::Vector3d::UnitZ()));
  Eigen::Matrix3d expected;
  expected << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  EXPECT_TRUE(parallel.isApprox(expected)) << parallel;
}

}  // namespace
}  // namespace relief
