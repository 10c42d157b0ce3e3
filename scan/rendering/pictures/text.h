#pragma once

#include <string>

#include "relief/rendering/picture.h"

namespace relief::rendering {

/// The height of a line of text with the space round it [pixels].
inline constexpr int kLineHeight = 24;

/// How wide a line of text is [pixels].
int text_width(const std::string& text);

/// Draws a line of text in black whose line begins at (left, top) and is kLineHeight high. What is
/// beyond the picture is left out. UTF-8.
void draw_text(Picture& picture, int left, int top, const std::string& text);

}  // namespace relief::rendering
