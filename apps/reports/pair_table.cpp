#include "apps/reports/pair_table.h"

#include <algorithm>

#include <fmt/format.h>

namespace relief {

std::vector<std::string> pair_table(const registration::Alignment& alignment,
                                    const std::string& unit) {
  std::size_t width = 4;
  for (const registration::PairFit& pair : alignment.pairs)
    width = std::max(width,
                     alignment.views[pair.a].name.size() + 3 + alignment.views[pair.b].name.size());
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("{:<{}}  overlap  {:>10}  samples  grade", "pair", width, "rms [" + unit + "]"));
  for (const registration::PairFit& pair : alignment.pairs) {
    const std::string names = alignment.views[pair.a].name + " - " + alignment.views[pair.b].name;
    lines.push_back(fmt::format("{:<{}}  {:>5.0f} %  {:>10.3g}  {:>7}  {}{}", names, width,
                                100.0 * pair.overlap, pair.rms, pair.correspondences,
                                to_string(pair.grade), pair.normal_maps ? ", normal maps" : ""));
    for (const registration::DegenerateDirection& direction : pair.degenerate_directions)
      lines.push_back("    alone leaves free: " + direction.description);
  }
  return lines;
}

std::string count_grades(const registration::Alignment& alignment) {
  std::string text = fmt::format("{} pairs", alignment.pairs.size());
  const char* separator = ": ";
  for (const registration::PairGrade grade :
       {registration::PairGrade::kFirm, registration::PairGrade::kSlides,
        registration::PairGrade::kThin, registration::PairGrade::kMisfit}) {
    const auto count =
        std::count_if(alignment.pairs.begin(), alignment.pairs.end(),
                      [&](const registration::PairFit& pair) { return pair.grade == grade; });
    if (count == 0) continue;
    text += fmt::format("{}{} {}", separator, count, to_string(grade));
    separator = ", ";
  }
  return text;
}

}  // namespace relief
