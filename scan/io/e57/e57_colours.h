#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/scan/grid.h"
#include "scan/io/e57/e57_layout.h"

namespace relief {

/// The colours of the records of a scan, scaled to 8 bit: by the scan's limits, else by those of
/// the fields colorRed, colorGreen, colorBlue, which it has, else by the usual ones that hold all
/// values, with a note. Records whose `skipped` is not 0 become black.
std::vector<Colour> colours_of_e57(const E57Scan& scan,
                                   std::span<const std::array<float, 3>> values,
                                   std::span<const std::uint8_t> skipped,
                                   std::vector<std::string>& notes);

/// Grey by intensity: by the scan's limits, else by those of the values that are not skipped.
/// Empty when all of these are the same, which tells nothing.
std::vector<Colour> greys_of_e57(const E57Scan& scan, std::span<const float> values,
                                 std::span<const std::uint8_t> skipped,
                                 std::vector<std::string>& notes);

}  // namespace relief
