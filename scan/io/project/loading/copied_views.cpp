#include "scan/io/project/loading/copied_views.h"

#include <algorithm>
#include <cstddef>
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

// Which of two views with the same samples to keep: one with a pose, else one with colours or
// normals of its own.
bool tells_more(const RangeView& a, const RangeView& b) {
  const auto told = [](const RangeView& view) {
    return std::tuple(view.pose != PoseKind::kAbsent,
                      (view.colours.empty() ? 0 : 1) + (view.normals.empty() ? 0 : 1));
  };
  return told(a) > told(b);
}

// A view and the one that it is a copy of.
struct Copy {
  std::size_t view = 0, original = 0;
};

std::vector<Copy> find_copies(const std::vector<RangeView>& views) {
  std::vector<Copy> copies;
  std::multimap<std::size_t, std::size_t> by_samples;  // Originals.
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto [begin, end] = by_samples.equal_range(views[i].sample_count());
    const auto equal = std::find_if(begin, end, [&](const auto& entry) {
      return have_equal_points(views[entry.second], views[i]);
    });
    if (equal == end) {
      by_samples.emplace(views[i].sample_count(), i);
      continue;
    }
    std::size_t copy = i;
    if (tells_more(views[i], views[equal->second])) std::swap(equal->second, copy);
    copies.push_back({copy, equal->second});
  }
  return copies;
}

std::string note_on(const std::vector<Copy>& copies, const std::vector<RangeView>& views,
                    const std::string& what_follows) {
  return "the ranges of " + std::to_string(copies.size()) + " of " + std::to_string(views.size()) +
         " views are those of another view, as of " + views[copies.front().view].name + " and " +
         views[copies.front().original].name + ": " + what_follows;
}

const char* const kKept = "leave copies out, as their noise seems to be shape";

}  // namespace

std::vector<std::string> leave_out_copies(std::vector<RangeView>& views) {
  std::vector<Copy> left_out, kept;
  for (const Copy& copy : find_copies(views))
    (views[copy.view].pose == PoseKind::kAbsent ? left_out : kept).push_back(copy);
  std::vector<std::string> notes;
  if (!left_out.empty()) notes.push_back(note_on(left_out, views, "these copies are left out"));
  if (!kept.empty()) notes.push_back(note_on(kept, views, kKept));
  std::vector<bool> gone(views.size(), false);
  for (const Copy& copy : left_out) gone[copy.view] = true;
  std::size_t next = 0;
  std::erase_if(views, [&](const RangeView&) { return gone[next++]; });
  return notes;
}

std::vector<std::string> notes_on_copies(const std::vector<RangeView>& views) {
  const auto copies = find_copies(views);
  if (copies.empty()) return {};
  return {note_on(copies, views, kKept)};
}

}  // namespace relief
