#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace relief {

/// The header of a Radiance picture.
struct HdrHeader {
  std::size_t width = 0, height = 0;  ///< As stored: of a line, and how many lines.
  std::uint16_t orientation = 1;      ///< As upright() takes it.
  std::size_t pixels_at = 0;          ///< [bytes]
  std::string format;                 ///< Empty: not told, which stands for RGBE.

  bool lines_are_columns() const { return orientation >= 5; }
};

/// Nothing unless the text is that of a Radiance picture, to the end of its line of sizes.
std::optional<HdrHeader> read_hdr_header(std::string_view content);

}  // namespace relief
