#pragma once

#include <string>
#include <vector>

#include "relief/registration/align_views.h"

namespace relief {

/// The pairs of an alignment as lines for people: names, overlap, RMS distance, correspondences and
/// grade, in columns under a heading; below each pair that alone leaves motions free, which ones.
std::vector<std::string> pair_table(const registration::Alignment& alignment,
                                    const std::string& unit);

/// How many pairs have each grade: `25 pairs: 20 firm, 3 slides, 2 thin`.
std::string count_grades(const registration::Alignment& alignment);

}  // namespace relief
