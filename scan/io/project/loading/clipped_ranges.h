#pragma once

#include <optional>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// Names a view in which many samples have exactly the smallest or the largest depth of all, far
/// more than have the next one: as where a sensor writes the limit of its range for all that is
/// beyond. They are not left out, since a flat surface that faces a sensor without noise looks
/// alike. Nothing where there is no such view.
std::optional<std::string> note_on_clipped_ranges(const std::vector<RangeView>& views);

}  // namespace relief
