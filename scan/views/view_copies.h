#pragma once

#include <cstddef>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// For each view the index of the view that it is a copy of, itself where it is none. Copies have
/// the samples of the other one to the bit, under the same camera: they are no scans of their own.
/// Of equal views the original has a known pose, else a guess, where one of them has; of those with
/// such poses, it has colours or normals; of these it is the first one. A view without samples is
/// no copy.
std::vector<std::size_t> originals_of(const std::vector<RangeView>& views);

}  // namespace relief
