#pragma once

#include <string>
#include <vector>

#include "scan/range_view.h"

namespace relief {

/// Several range views of one object, in one length unit.
struct ScanProject {
  std::string unit = "mm";  ///< Of every length, e.g. `mm` or `m`; nothing depends on it.
  std::vector<RangeView> views;
  /// What the reader had to find out by itself (camera models, axes of normals), one line each, for
  /// the user's log.
  std::vector<std::string> notes;
};

}  // namespace relief
