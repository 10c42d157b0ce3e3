#include "scan/io/project/loading/copied_views.h"

#include <cstddef>
#include <string>
#include <vector>

#include "scan/views/view_copies.h"

namespace relief {

namespace {

// A view and the one that it is a copy of.
struct Copy {
  std::size_t view = 0, original = 0;
};

std::vector<Copy> find_copies(const std::vector<RangeView>& views) {
  const auto originals = originals_of(views);
  std::vector<Copy> copies;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (originals[i] != i) copies.push_back({i, originals[i]});
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
