#include "scan/io/project/loading/clipped_ranges.h"

#include <cmath>
#include <cstddef>
#include <sstream>

namespace relief {

namespace {

constexpr std::size_t kFewest = 100;  // Samples that are worth a note.
constexpr double kShare = 0.01;       // Of all samples, the same.
// Times as many as have the next depth. A smooth surface has about as many samples in each step of
// the depth up to its nearest point, and an edge fewer.
constexpr std::size_t kPile = 20;

// How many samples have the least value, and how many the next.
struct LeastValues {
  double least = 0.0, next = 0.0;
  std::size_t of_least = 0, of_next = 0;

  void add(double value) {
    if (of_least == 0 || value < least) {
      next = least;
      of_next = of_least;
      least = value;
      of_least = 1;
    } else if (value == least) {
      ++of_least;
    } else if (of_next == 0 || value < next) {
      next = value;
      of_next = 1;
    } else if (value == next) {
      ++of_next;
    }
  }

  bool are_piled_up(std::size_t samples) const {
    return of_next > 0 && of_least >= kFewest &&
           static_cast<double>(of_least) >= kShare * static_cast<double>(samples) &&
           of_least >= kPile * of_next;
  }
};

}  // namespace

std::optional<ClippedRanges> find_clipped_ranges(const RangeView& view) {
  LeastValues nearest, farthest;
  std::size_t samples = 0;
  for (const double range : view.range) {
    if (std::isnan(range)) continue;
    ++samples;
    nearest.add(range);
    farthest.add(-range);
  }
  if (nearest.are_piled_up(samples))
    return ClippedRanges{view.name, nearest.of_least, samples, nearest.least, true};
  if (farthest.are_piled_up(samples))
    return ClippedRanges{view.name, farthest.of_least, samples, -farthest.least, false};
  return std::nullopt;
}

std::optional<std::string> note_on_clipped_ranges(const std::vector<ClippedRanges>& clipped,
                                                  std::size_t views) {
  if (clipped.empty()) return std::nullopt;
  const ClippedRanges& first = clipped.front();
  std::ostringstream note;
  note << "warning: in " << clipped.size() << " of " << views
       << " views many samples have exactly the " << (first.is_nearest ? "smallest" : "largest")
       << " depth, as " << first.count << " of " << first.samples << " in view " << first.view
       << " at " << first.limit
       << ": unless a flat surface faces the sensor there, it writes the limit of its range for "
          "all that is beyond; mask these samples, they are no surface";
  return note.str();
}

}  // namespace relief
