#include <algorithm>
#include <cstdio>

#include "relief/rendering/picture.h"
#include "scan/rendering/pictures/text.h"

namespace relief::rendering {

namespace {

constexpr int kGap = 8, kBarHeight = 12, kLongestBar = 256;  // [pixels]

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

void fill(Picture& picture, int left, int top, int width, int height, const Colour& colour) {
  for (int v = top; v < top + height; ++v)
    for (int u = left; u < left + width; ++u)
      if (picture.contains(u, v)) picture(u, v) = {colour[0], colour[1], colour[2], 255};
}

void copy_to(Picture& target, const Picture& source, int left, int top) {
  for (int v = 0; v < source.height(); ++v)
    for (int u = 0; u < source.width(); ++u)
      if (target.contains(left + u, top + v)) target(left + u, top + v) = source(u, v);
}

// Draws text and tells where it ends.
int write(Picture& picture, int left, int top, const std::string& text) {
  if (text.empty()) return left;
  draw_text(picture, left, top, text);
  return left + text_width(text) + kGap;
}

int draw_bar(Picture& picture, int left, int top, int width, const Legend& legend) {
  left = write(picture, left, top, number(legend.low));
  const int steps = static_cast<int>(legend.bar.size()) - 1;
  for (int u = 0; u < width; ++u)
    fill(picture, left + u, top + (kLineHeight - kBarHeight) / 2, 1, kBarHeight,
         legend.bar[static_cast<std::size_t>(u * steps / (width - 1))]);
  return write(picture, left + width + kGap, top, number(legend.high));
}

// Draws the whole strip and tells where it ends.
int draw_strip(Picture& picture, int top, int bar_width, const Legend& legend) {
  int left = write(picture, kGap, top, legend.title);
  if (!legend.bar.empty()) left = draw_bar(picture, left, top, bar_width, legend);
  for (const Legend::Entry& entry : legend.entries) {
    fill(picture, left, top + (kLineHeight - kBarHeight) / 2, kBarHeight, kBarHeight, entry.colour);
    left = write(picture, left + kBarHeight + kGap / 2, top, entry.text);
  }
  return left;
}

}  // namespace

std::string describe(const Legend& legend) {
  std::string text = legend.title;
  if (!legend.bar.empty()) text += ": " + number(legend.low) + " to " + number(legend.high);
  for (const Legend::Entry& entry : legend.entries) {
    char colour[16];
    std::snprintf(colour, sizeof colour, "#%02x%02x%02x", entry.colour[0], entry.colour[1],
                  entry.colour[2]);
    text += (text.empty() ? "" : ", ") + entry.text + ": " + colour;
  }
  return text;
}

Picture with_legend(const Picture& picture, const Legend& legend, Background background) {
  const int bar_width = std::clamp(picture.width() / 4, 2, kLongestBar);
  Picture nowhere;
  const int width = std::max(picture.width(), draw_strip(nowhere, 0, bar_width, legend));
  Picture result(width, picture.height() + kLineHeight, background_colour(background));
  copy_to(result, picture, (width - picture.width()) / 2, 0);
  draw_strip(result, picture.height(), bar_width, legend);
  return result;
}

Picture with_caption(const Picture& picture, const std::string& caption, Background background) {
  const int width = std::max(picture.width(), text_width(caption) + 2 * kGap);
  Picture result(width, picture.height() + kLineHeight, background_colour(background));
  copy_to(result, picture, (width - picture.width()) / 2, kLineHeight);
  write(result, kGap, 0, caption);
  return result;
}

}  // namespace relief::rendering
