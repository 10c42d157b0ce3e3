#include "scan/rendering/pictures/text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <vtkFreeTypeTools.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>

namespace relief::rendering {

namespace {

constexpr int kFontSize = 15, kDotsPerInch = 72;  // Points are pixels at 72.
constexpr int kBaseline = 17;                     // Below the top of the line [pixels].

// The opacity of every pixel of a text, with the font that VTK brings along. Its origin is at the
// left end of the baseline, its rows go up.
struct TextImage {
  vtkNew<vtkImageData> image;
  std::array<int, 6> extent{0, -1, 0, -1, 0, -1};

  explicit TextImage(const std::string& text) {
    if (text.empty()) return;
    vtkNew<vtkTextProperty> property;
    property->SetFontFamilyToArial();
    property->SetFontSize(kFontSize);
    property->SetColor(0.0, 0.0, 0.0);
    property->SetJustificationToLeft();
    property->SetVerticalJustificationToBottom();
    auto* tools = vtkFreeTypeTools::GetInstance();
    tools->ScaleToPowerTwoOff();
    if (tools->RenderString(property, vtkStdString(text), kDotsPerInch, image))
      image->GetExtent(extent.data());
  }

  int opacity(int x, int y) const {
    return static_cast<const unsigned char*>(
        const_cast<vtkImageData*>(image.Get())->GetScalarPointer(x, y, 0))[3];
  }
};

// Black with an opacity over a pixel.
Rgba covered(const Rgba& below, int opacity) {
  const double over = opacity / 255.0, under = (1.0 - over) * below[3] / 255.0;
  const double both = over + under;
  if (!(both > 0.0)) return below;
  Rgba result;
  for (std::size_t k = 0; k < 3; ++k)
    result[k] = static_cast<std::uint8_t>(std::lround(under * below[k] / both));
  result[3] = static_cast<std::uint8_t>(std::lround(255.0 * both));
  return result;
}

}  // namespace

int text_width(const std::string& text) {
  const TextImage drawn(text);
  return std::max(0, drawn.extent[1] - drawn.extent[0] + 1);
}

void draw_text(Picture& picture, int left, int top, const std::string& text) {
  const TextImage drawn(text);
  for (int y = drawn.extent[2]; y <= drawn.extent[3]; ++y) {
    for (int x = drawn.extent[0]; x <= drawn.extent[1]; ++x) {
      const int u = left + x - drawn.extent[0], v = top + kBaseline - y;
      if (picture.contains(u, v)) picture(u, v) = covered(picture(u, v), drawn.opacity(x, y));
    }
  }
}

}  // namespace relief::rendering
