#include "scan/io/project/loading/copied_views.h"

#include <algorithm>
#include <cstddef>
#include <map>
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

// Which of two views with the same samples to keep: one with colours or normals of its own.
bool tells_more(const RangeView& a, const RangeView& b) {
  const auto told = [](const RangeView& view) {
    return (view.colours.empty() ? 0 : 1) + (view.normals.empty() ? 0 : 1);
  };
  return told(a) > told(b);
}

}  // namespace

std::vector<std::string> leave_out_copies(std::vector<RangeView>& views) {
  std::multimap<std::size_t, std::size_t> by_samples;
  std::vector<bool> left_out(views.size(), false);
  std::string kept_example, left_out_example;
  const auto name = [&](std::size_t copy, std::size_t original, std::string& example) {
    if (example.empty()) example = "as of " + views[copy].name + " and " + views[original].name;
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::size_t samples = views[i].sample_count();
    const auto [begin, end] = by_samples.equal_range(samples);
    const auto equal = std::find_if(begin, end, [&](const auto& entry) {
      return have_equal_points(views[entry.second], views[i]);
    });
    if (equal == end) {
      by_samples.emplace(samples, i);
      continue;
    }
    std::size_t original = equal->second, copy = i;
    if (views[i].pose != PoseKind::kAbsent || views[original].pose != PoseKind::kAbsent) {
      ++kept;
      name(copy, original, kept_example);
      continue;
    }
    if (tells_more(views[copy], views[original])) std::swap(equal->second, copy);
    left_out[copy] = true;
    name(copy, equal->second, left_out_example);
  }
  const auto all = " of " + std::to_string(views.size()) + " views are those of another view, ";
  const auto copies = std::ranges::count(left_out, true);
  std::vector<std::string> notes;
  if (copies > 0)
    notes.push_back("the samples of " + std::to_string(copies) + all + left_out_example +
                    ": these copies are left out");
  if (kept > 0)
    notes.push_back("the samples of " + std::to_string(kept) + all + kept_example +
                    ": leave copies out, as their noise seems to be shape");
  std::size_t next = 0;
  std::erase_if(views, [&](const RangeView&) { return left_out[next++]; });
  return notes;
}

}  // namespace relief
