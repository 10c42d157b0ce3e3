#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>
#include <vector>

#include "scan/base/median.h"
#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

namespace relief {

namespace {

// Values per metre that cameras and sets of 16-bit images use: millimetres; TUM's; a tenth of a
// millimetre (short-range stereo); a quarter (RealSense L515).
constexpr double kUsualScales[] = {1000.0, 5000.0, 10000.0, 4000.0};
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
  if (values_per_metre == 1.0) return "metres";
  std::snprintf(text, sizeof text, "%g to the metre", values_per_metre);
  return text;
}

AssumedDepthScale assumed(double values_per_metre, const std::string& why) {
  return {1.0 / values_per_metre,
          "no scale of the depth maps is given: their values are taken as " +
              words(values_per_metre) + why + "; --depth-scale N says how many make a metre"};
}

}  // namespace

std::optional<AssumedDepthScale> assume_depth_scale(const ProjectSpec& project, double usual,
                                                    const ComparedDepths& compared) {
  if (project.views.empty() || !project.views.front().depth || !project.views.front().camera)
    return std::nullopt;
  const ViewSpec& first = project.views.front();
  const auto image = read_image(first.depth->file, first.depth->size);
  if (!image || image->channels != 1) return std::nullopt;
  const bool integers = image->max_value > 0.0;
  if (integers && image->max_value < 65535.0) return std::nullopt;
  if (!integers) usual = median_depth(*image) > kFarthest ? kMillimetres : 1.0;

  std::vector<double> scales;
  std::vector<DepthReading> readings;
  const auto add = [&](double scale) {
    if (std::find(scales.begin(), scales.end(), scale) != scales.end()) return;
    scales.push_back(scale);
    readings.push_back({.poses = {.unit = scale}});  // As depths divided by it.
  };
  const bool shifted = integers && are_shifted(*image);
  if (shifted) usual *= kShifted;
  add(usual);
  if (integers)
    for (const double scale : kUsualScales) {
      add(scale);
      if (shifted) add(kShifted * scale);
    }
  const auto found = compared.disagreements(project, readings);
  std::size_t best = 0;
  for (std::size_t k = 1; k < scales.size(); ++k)
    if (found[0] && found[k] && found[k]->median < found[best]->median) best = k;
  if (best == 0 || !(found[0]->median > kFarBetter * found[best]->median))
    return assumed(usual, shifted ? ", since all are multiples of 8, as SUN3D writes them" : "");
  char why[120];
  std::snprintf(why, sizeof why,
                ", with which they agree at their poses to %.2g %% (as %s %.2g %%)",
                100.0 * found[best]->median, words(usual).c_str(), 100.0 * found[0]->median);
  return assumed(scales[best], why);
}

}  // namespace relief
