#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>
#include <vector>

#include "scan/base/median.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"
#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"

namespace relief {

namespace {

// Values per metre that cameras and sets of 16-bit images use: millimetres; TUM's; a tenth of a
// millimetre (short-range stereo); a quarter (RealSense L515); centimetres (Virtual KITTI).
constexpr double kUsualScales[] = {1000.0, 5000.0, 10000.0, 4000.0, 100.0};
// No depth camera sees so far [m], and no object is scanned from as many millimetres.
constexpr double kFarthest = 50.0;

// SUN3D and its kin write the depth in the upper 13 bits.
constexpr double kShifted = 8.0;

// By chance as many different values are hardly ever all multiples: 8^-8.
constexpr std::size_t kTellingValues = 8;

bool are_shifted(const Image& image) {
  std::set<float> values;  // Above 0, no more than tell.
  for (const float z : image.samples) {
    if (std::fmod(z, kShifted) != 0.0) return false;
    if (z > 0.0f && values.size() < kTellingValues) values.insert(z);
  }
  return values.size() == kTellingValues;
}

double median_depth(const Image& image) {
  std::vector<double> depths;
  for (const float z : image.samples)
    if (z > 0.0f && std::isfinite(z)) depths.push_back(z);
  return median(std::move(depths));
}

std::string words(double values_per_metre) {
  char text[80];
  if (values_per_metre == kMillimetres) return "millimetres";
  if (values_per_metre == 100.0) return "centimetres";
  if (values_per_metre == 1.0) return "metres";
  std::snprintf(text, sizeof text, "%g to the metre", values_per_metre);
  return text;
}

// The usual one first.
std::vector<double> possible_scales(double usual, bool shifted) {
  std::vector<double> scales = {usual};
  const auto add = [&](double scale) {
    if (std::ranges::find(scales, scale) == scales.end()) scales.push_back(scale);
  };
  for (const double scale : kUsualScales) {
    add(scale);
    if (shifted) add(kShifted * scale);
  }
  return scales;
}

// Of scales, the one in which the maps agree in some convention of poses, if it is one alone: as
// depth cameras do, and far better than `as_given`.
std::optional<std::size_t> scale_in_any_convention(const std::vector<double>& scales,
                                                   const ProjectSpec& project,
                                                   const ComparedDepths& compared,
                                                   const Disagreement& as_given) {
  std::vector<double> least(scales.size(), 1.0);  // Disagreement in any convention.
  for (std::size_t k = 0; k < scales.size(); ++k) {
    std::vector<DepthReading> readings;
    for (PoseConvention convention : possible_conventions()) {
      if (convention.unit != 1.0) continue;  // A unit and a scale are told apart by no map.
      convention.unit = scales[k];           // As depths divided by it.
      readings.push_back({.poses = convention});
    }
    for (const auto& found : compared.disagreements(project, readings))
      if (found && 2 * found->pixels >= as_given.pixels)  // Few pixels may agree by chance.
        least[k] = std::min(least[k], found->median);
  }
  const auto best = std::ranges::min_element(least);
  if (!(*best < std::min(kCameraError, as_given.median / kFarBetter))) return std::nullopt;
  const bool is_alone =
      std::ranges::count_if(least, [&](double other) { return other <= kFarBetter * *best; }) == 1;
  return is_alone ? std::optional(static_cast<std::size_t>(best - least.begin())) : std::nullopt;
}

AssumedDepthScale assumed(double values_per_metre, const std::string& why) {
  return {1.0 / values_per_metre,
          "no scale of the depth maps is given: their values are taken as " +
              words(values_per_metre) + why + "; --depth-scale N says how many make a metre"};
}

std::string agreement_text(const Disagreement& taken, double usual,
                           const std::optional<Disagreement>& as_usual) {
  char text[80];
  std::snprintf(text, sizeof text, ", with which they agree at their poses to %.2g %%",
                100.0 * taken.median);
  const std::string agreement = text;
  if (!as_usual) return agreement + " (as " + words(usual) + " they do not meet)";
  std::snprintf(text, sizeof text, " %.2g %%)", 100.0 * as_usual->median);
  return agreement + " (as " + words(usual) + text;
}

}  // namespace

Result<AssumedDepthScale> assume_depth_scale(const ProjectSpec& project, double usual,
                                             const ComparedDepths& compared) {
  const ViewSpec& first = project.views.front();
  const auto image = read_depth_image(first.depth->file, first.depth->size);
  if (!image) return image.error();
  const bool integers = image->max_value > 0.0;
  if (integers && image->max_value < 65535.0)
    return bad_input(first.depth->file,
                     "has 8 bits a pixel, as a picture of depths has: give the folder of the depth "
                     "maps themselves, or --depth-scale N where N values make a metre");
  if (!integers) usual = median_depth(*image) > kFarthest ? kMillimetres : 1.0;

  const bool shifted = integers && are_shifted(*image);
  if (shifted) usual *= kShifted;
  const auto scales = integers ? possible_scales(usual, shifted) : std::vector{usual};
  std::vector<DepthReading> readings;  // Units as depths divided by the scales.
  for (const double scale : scales) readings.push_back({.poses = {.unit = scale}});
  const auto found = compared.disagreements(project, readings);
  std::size_t best = 0;
  for (std::size_t k = 1; k < scales.size(); ++k)
    if (found[k] && (!found[best] || found[k]->median < found[best]->median)) best = k;
  if (found[0] && found[best]->median > kBeyondCameraError)
    if (const auto other = scale_in_any_convention(scales, project, compared, *found[best]))
      return assumed(scales[*other], ", with which they agree in another convention of the poses");
  // Where views do not meet as usual, they must agree as depth cameras do.
  const bool told = best > 0 && (found[0] ? found[0]->median > kFarBetter * found[best]->median
                                          : found[best]->median < kCameraError);
  if (!told)
    return assumed(usual, shifted ? ", since all are multiples of 8, as SUN3D writes them" : "");
  return assumed(scales[best], agreement_text(*found[best], usual, found[0]));
}

}  // namespace relief
