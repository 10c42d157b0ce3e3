#include "scan/io/e57/e57_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace relief {

namespace {

constexpr std::array<const char*, 3> kColourFields{"colorRed", "colorGreen", "colorBlue"};

bool is_range(const std::optional<E57Limits>& limits) {
  return limits && std::isfinite(limits->high - limits->low) && limits->low < limits->high;
}

std::uint8_t level_of(double value, const E57Limits& limits) {
  const double level = 255.0 * (value - limits.low) / (limits.high - limits.low);
  return static_cast<std::uint8_t>(std::lround(level > 0.0 ? std::min(level, 255.0) : 0.0));
}

// Of the finite values that are not skipped; low is above high when there are none.
template <typename Value>
E57Limits limits_of_values(std::span<const std::uint8_t> skipped, const Value& value) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  E57Limits limits{kInfinity, -kInfinity};
  for (std::size_t i = 0; i < skipped.size(); ++i) {
    if (skipped[i] != 0 || !std::isfinite(value(i))) continue;
    limits.low = std::min<double>(limits.low, value(i));
    limits.high = std::max<double>(limits.high, value(i));
  }
  return limits;
}

// Reals that tell no limits are commonly from 0 to 1, but also 8-bit or 16-bit numbers.
double usual_maximum(double found, E57Field::Type type) {
  if (found <= 1.0 && type != E57Field::Type::kInteger) return 1.0;
  return found <= 255.0 ? 255.0 : 65535.0;
}

}  // namespace

std::vector<Colour> colours_of_e57(const E57Scan& scan,
                                   std::span<const std::array<float, 3>> values,
                                   std::span<const std::uint8_t> skipped,
                                   std::vector<std::string>& notes) {
  std::vector<Colour> colours(values.size(), Colour{});
  for (std::size_t k = 0; k < kColourFields.size(); ++k) {
    const E57Field& field = *scan.find(kColourFields[k]);
    std::optional<E57Limits> limits = scan.colour_limits[k];
    if (!is_range(limits) && field.bits < 64) limits = field.limits;
    if (!is_range(limits)) {
      const auto found = limits_of_values(skipped, [&](std::size_t i) { return values[i][k]; });
      limits = E57Limits{0.0, usual_maximum(found.high, field.type)};
      notes.push_back("the scan tells no limits of " + field.name + "; taken to be from 0 to " +
                      std::to_string(static_cast<int>(limits->high)));
    }
    for (std::size_t i = 0; i < values.size(); ++i)
      if (skipped[i] == 0) colours[i][k] = level_of(values[i][k], *limits);
  }
  return colours;
}

std::vector<Colour> greys_of_e57(const E57Scan& scan, std::span<const float> values,
                                 std::span<const std::uint8_t> skipped,
                                 std::vector<std::string>& notes) {
  const auto found = limits_of_values(skipped, [&](std::size_t i) { return values[i]; });
  if (!(found.low < found.high)) return {};
  const E57Limits limits = is_range(scan.intensity_limits) ? *scan.intensity_limits : found;
  std::vector<Colour> colours(values.size(), Colour{});
  for (std::size_t i = 0; i < values.size(); ++i)
    if (skipped[i] == 0) colours[i].fill(level_of(values[i], limits));
  notes.push_back("the scan has no colours; its intensities are taken as grey");
  return colours;
}

}  // namespace relief
