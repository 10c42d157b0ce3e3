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

struct ClippedSamples {
  std::size_t count = 0, samples = 0;
  double limit = 0.0;  // [unit]
  bool is_nearest = false;
};

std::optional<ClippedSamples> find_clipped(const RangeView& view) {
  LeastValues nearest, farthest;
  std::size_t samples = 0;
  for (const double range : view.range) {
    if (std::isnan(range)) continue;
    ++samples;
    nearest.add(range);
    farthest.add(-range);
  }
  if (nearest.are_piled_up(samples))
    return ClippedSamples{nearest.of_least, samples, nearest.least, true};
  if (farthest.are_piled_up(samples))
    return ClippedSamples{farthest.of_least, samples, -farthest.least, false};
  return std::nullopt;
}

}  // namespace

std::optional<std::string> note_on_clipped_ranges(const std::vector<RangeView>& views) {
  std::ostringstream note;
  std::size_t clipped_views = 0;
  for (const RangeView& view : views) {
    const auto clipped = find_clipped(view);
    if (!clipped || ++clipped_views > 1) continue;
    note << " many samples have exactly the " << (clipped->is_nearest ? "smallest" : "largest")
         << " depth, as " << clipped->count << " of " << clipped->samples << " in view "
         << view.name << " at " << clipped->limit
         << ": unless a flat surface faces the sensor there, it writes the limit of its range for "
            "all that is beyond; mask these samples, they are no surface";
  }
  if (clipped_views == 0) return std::nullopt;
  return "warning: in " + std::to_string(clipped_views) + " of " + std::to_string(views.size()) +
         " views" + note.str();
}

}  // namespace relief
