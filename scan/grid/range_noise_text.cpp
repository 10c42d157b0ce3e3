#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "scan/base/median.h"
#include "scan/grid/range_noise.h"

namespace relief {

namespace {

// Ratio of the noise of parts of a view that is worth a word. It changes texts only.
constexpr double kWorthAWord = 1.3;

std::string number(double value, const char* format = "%.3g") {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

// Two halves of a view and the names of theirs.
struct Split {
  const char *first, *second;
  std::vector<float> in_first, in_second;

  double ratio() {
    const double a = median(in_first), b = median(in_second);
    return a > 0.0 && b > 0.0 ? a / b : 1.0;
  }
};

template <typename Visit>
void for_samples(const RangeView& view, const Visit& visit) {
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) visit(u, v);
}

std::array<double, 3> middle_of(const RangeView& view) {
  std::array<std::vector<double>, 3> all;
  for_samples(view, [&](int u, int v) {
    all[0].push_back(u);
    all[1].push_back(v);
    all[2].push_back(view.range(u, v));
  });
  return {median(all[0]), median(all[1]), median(all[2])};
}

std::string where_larger(const RangeNoise& noise, const RangeView& view) {
  std::array<Split, 3> splits{{{"at the left", "at the right", {}, {}},
                               {"at the top", "at the bottom", {}, {}},
                               {"where the surface is near", "where it is far", {}, {}}}};
  const std::array<double, 3> middle = middle_of(view);
  for_samples(view, [&](int u, int v) {
    const std::array<double, 3> at{double(u), double(v), view.range(u, v)};
    for (std::size_t k = 0; k < 3; ++k)
      (at[k] < middle[k] ? splits[k].in_first : splits[k].in_second).push_back(noise.map(u, v));
  });
  std::string words;
  double largest = kWorthAWord;
  for (Split& split : splits) {
    const double ratio = split.ratio();
    if (std::max(ratio, 1.0 / ratio) < largest) continue;
    largest = std::max(ratio, 1.0 / ratio);
    const auto [more, less] =
        ratio > 1.0 ? std::pair{split.first, split.second} : std::pair{split.second, split.first};
    words = ", " + number(largest, "%.1f") + " times larger " + more + " than " + less;
  }
  return words;
}

std::string spread_of(const RangeNoise& noise, const RangeView& view) {
  std::vector<float> sigmas;
  for_samples(view, [&](int u, int v) { sigmas.push_back(noise.map(u, v)); });
  std::sort(sigmas.begin(), sigmas.end());
  const auto at = [&](double fraction) {
    return double{sigmas[static_cast<std::size_t>(fraction * double(sigmas.size() - 1))]};
  };
  return at(0.95) < kWorthAWord * at(0.05)
             ? std::string()
             : ", from " + number(at(0.05)) + " to " + number(at(0.95)) + " over the view";
}

std::string describe_steps(const RangeQuantisation& quantisation, const RangeView& view,
                           const std::string& unit) {
  if (!quantisation.exists()) return {};
  if (quantisation.inverse_step == 0.0)
    return "range in steps of " + number(quantisation.step) + unit + "; ";
  std::vector<double> ranges;
  for_samples(view, [&](int u, int v) { ranges.push_back(view.range(u, v)); });
  std::sort(ranges.begin(), ranges.end());
  const double near = ranges[ranges.size() / 20],
               far = ranges[ranges.size() - ranges.size() / 20 - 1];
  const auto step = [&](double range) { return number(quantisation.step_at(range, 1.0)) + unit; };
  return "inverse range in steps: " + step(near) + " at " + number(near) + unit + ", " + step(far) +
         " at " + number(far) + unit + "; ";
}

}  // namespace

std::string describe(const RangeNoise& noise, const RangeView& view, const std::string& unit) {
  const std::string suffix = unit.empty() ? std::string() : " " + unit;
  std::string words = describe_steps(noise.quantisation, view, suffix);
  if (!noise.known()) return words + "noise unknown";
  words += "noise " + number(noise.sigma) + suffix;
  if (noise.map.empty()) return words;
  const std::string where = where_larger(noise, view);
  return words + (where.empty() ? spread_of(noise, view) : where);
}

}  // namespace relief
