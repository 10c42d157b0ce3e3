#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"

namespace relief {

/// The pixels of a view that become records of an E57 file: those with a sample.
struct E57RecordPlan {
  const RangeView* view = nullptr;  ///< Outlives the plan.
  double metres_per_unit = 1.0;
  std::vector<std::array<int, 2>> pixels;         ///< u and v of each record, row by row.
  Eigen::Vector3d low = Eigen::Vector3d::Zero();  ///< Bounds of the points, view frame [m].
  Eigen::Vector3d high = Eigen::Vector3d::Zero();

  /// Of a record, in the view frame [m].
  Eigen::Vector3d point(std::size_t record) const {
    return view->point(pixels[record][0], pixels[record][1]) * metres_per_unit;
  }
};

E57RecordPlan plan_e57_records(const RangeView& view, double metres_per_unit);

/// Appends the section of a view's points to the payload of a file. Fields: x, y, z, row, column,
/// then the colour if the view has colours, then the normal if it has normals.
void append_e57_section(std::string& payload, const E57RecordPlan& plan);

}  // namespace relief
