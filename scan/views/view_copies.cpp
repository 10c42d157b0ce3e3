#include "scan/views/view_copies.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace relief {

namespace {

// Cameras are compared at two corners.
bool have_equal_points(const RangeView& a, const RangeView& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (const auto& [u, v] : {std::pair{0, 0}, std::pair{a.width() - 1, a.height() - 1}}) {
    const Ray of_a = a.camera.ray(u, v), of_b = b.camera.ray(u, v);
    if (of_a.origin != of_b.origin || of_a.direction != of_b.direction) return false;
  }
  const auto same = [](double x, double y) { return x == y || (x != x && y != y); };
  return std::equal(a.range.begin(), a.range.end(), b.range.begin(), same);
}

// Equal for views with equal ranges, and for hardly any others: how many samples there are, and
// the sum of their ranges.
std::pair<std::size_t, double> key_of(const RangeView& view) {
  std::pair<std::size_t, double> key;
  for (const double range : view.range)
    if (range == range) {
      ++key.first;
      key.second += range;
    }
  return key;
}

bool tells_more(const RangeView& a, const RangeView& b) {
  const auto told = [](const RangeView& view) {
    return std::tuple(view.pose, (view.colours.empty() ? 0 : 1) + (view.normals.empty() ? 0 : 1));
  };
  return told(a) > told(b);
}

}  // namespace

std::vector<std::size_t> originals_of(const std::vector<RangeView>& views) {
  std::vector<std::size_t> first_of(views.size());  // Of the views with the same samples.
  std::vector<std::size_t> original_of_first(views.size());
  std::multimap<std::pair<std::size_t, double>, std::size_t> firsts;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto key = key_of(views[i]);
    const auto [begin, end] = firsts.equal_range(key);
    const auto equal = std::find_if(begin, end, [&](const auto& entry) {
      return key.first > 0 && have_equal_points(views[entry.second], views[i]);
    });
    first_of[i] = equal == end ? i : equal->second;
    if (equal == end) {
      original_of_first[i] = i;
      firsts.emplace(key, i);
    } else if (tells_more(views[i], views[original_of_first[first_of[i]]])) {
      original_of_first[first_of[i]] = i;
    }
  }
  std::vector<std::size_t> originals;
  for (const std::size_t first : first_of) originals.push_back(original_of_first[first]);
  return originals;
}

}  // namespace relief
