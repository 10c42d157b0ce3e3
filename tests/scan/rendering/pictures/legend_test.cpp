#include <algorithm>

#include <gtest/gtest.h>

#include "relief/rendering/picture.h"
#include "scan/rendering/pictures/colour_maps.h"
#include "scan/rendering/pictures/text.h"

namespace relief::rendering {
namespace {

const Rgba kGrey{90, 90, 90, 255};

int count_dark(const Picture& picture, int top, int bottom) {
  int dark = 0;
  for (int v = top; v < bottom; ++v)
    for (int u = 0; u < picture.width(); ++u)
      dark += picture(u, v)[0] < 60 && picture(u, v)[1] < 60 && picture(u, v)[3] > 128;
  return dark;
}

TEST(Legend, IsBelowThePictureAndLeavesItAsItIs) {
  const Picture picture(400, 50, kGrey);
  const Legend legend{"range [mm]", 1.0, 2.5, sequential_map(), {}};
  const Picture with = with_legend(picture, legend, Background::kWhite);
  ASSERT_EQ(with.width(), 400);
  ASSERT_EQ(with.height(), 50 + kLineHeight);
  EXPECT_TRUE(std::equal(picture.begin(), picture.end(), with.begin()));
  EXPECT_GT(count_dark(with, 50, with.height()), 50);  // letters
  const auto holds = [&](const Colour& colour) {
    return std::find(with.begin(), with.end(), Rgba{colour[0], colour[1], colour[2], 255}) !=
           with.end();
  };
  EXPECT_TRUE(holds(legend.bar.front()));
  EXPECT_TRUE(holds(legend.bar.back()));
}

TEST(Legend, WidensAPictureThatIsNarrower) {
  const Legend legend{"expected error [mm]", 0.0, 0.125, sequential_map(), {{{1, 2, 3}, "filled"}}};
  const Picture with = with_legend(Picture(20, 10, kGrey), legend, Background::kTransparent);
  EXPECT_GT(with.width(), text_width(legend.title) + text_width("filled"));
  EXPECT_EQ(with(0, 0), kNothing);
  EXPECT_EQ(with(with.width() / 2, 5), kGrey);
  // The last word is not cut.
  const Picture wider = with_legend(Picture(600, 10, kGrey), legend, Background::kTransparent);
  EXPECT_GE(count_dark(with, 10, 10 + kLineHeight), count_dark(wider, 10, 10 + kLineHeight) - 2);
}

TEST(Legend, SaysTheSameInWords) {
  EXPECT_EQ(describe(Legend{"range [mm]", 1.0, 2.5, sequential_map(), {}}), "range [mm]: 1 to 2.5");
  EXPECT_EQ(describe(Legend{"", 0, 0, {}, {{{255, 0, 16}, "filled"}}}), "filled: #ff0010");
}

TEST(Caption, IsAboveThePicture) {
  const Picture with = with_caption(Picture(200, 30, kGrey), "view 0,0", Background::kTransparent);
  ASSERT_EQ(with.height(), 30 + kLineHeight);
  EXPECT_GT(count_dark(with, 0, kLineHeight), 30);
  EXPECT_EQ(with(199, 0), kNothing);
  EXPECT_EQ(with(0, kLineHeight), kGrey);
}

TEST(Text, IsAsWideAsItsLetters) {
  EXPECT_EQ(text_width(""), 0);
  EXPECT_GT(text_width("mmmm"), 2 * text_width("iiii"));
}

TEST(Text, BeyondThePictureIsLeftOut) {
  Picture small(5, 5, kOpaqueWhite);
  draw_text(small, -20, -10, "longer than the picture");
  draw_text(small, 3, 3, "longer than the picture");
  EXPECT_EQ(small.width(), 5);
}

TEST(ContactSheet, PlacesPicturesRowByRow) {
  const std::vector<Picture> pictures{Picture(10, 4, {1, 0, 0, 255}), Picture(6, 8, {2, 0, 0, 255}),
                                      Picture(3, 3, {3, 0, 0, 255})};
  const Picture sheet = contact_sheet(pictures, 2, Background::kTransparent);
  EXPECT_EQ(sheet.width(), 10 + 8 + 6);
  EXPECT_EQ(sheet.height(), 8 + 8 + 3);
  EXPECT_EQ(sheet(0, 3)[0], 1);
  EXPECT_EQ(sheet(0, 4), kNothing);  // the first picture is lower than its row
  EXPECT_EQ(sheet(18, 0)[0], 2);
  EXPECT_EQ(sheet(3, 16)[0], 3);  // in the middle of its column
  EXPECT_EQ(sheet(12, 3), kNothing);
  EXPECT_EQ(contact_sheet({}, 2, Background::kWhite).size(), 0u);
}

TEST(ColourMaps, HaveTheirEnds) {
  const ColourMap map = sequential_map();
  EXPECT_EQ(colour_at(map, -3.0, 0.0, 1.0), (Colour{68, 1, 84}));
  EXPECT_EQ(colour_at(map, 1.0, 0.0, 1.0), (Colour{253, 231, 37}));
  const ColourMap signs = diverging_map();
  EXPECT_GT(colour_at(signs, -1.0, -1.0, 1.0)[2], 150);
  EXPECT_GT(colour_at(signs, 1.0, -1.0, 1.0)[0], 150);
  const Colour middle = colour_at(signs, 0.0, -1.0, 1.0);
  EXPECT_NEAR(middle[0], middle[2], 4);
}

TEST(ColourMaps, SequentialColoursGrowInBrightness) {
  double before = -1.0;
  for (const Colour& colour : sequential_map()) {
    const double brightness = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
    EXPECT_GE(brightness, before - 0.8);
    before = brightness;
  }
}

}  // namespace
}  // namespace relief::rendering
