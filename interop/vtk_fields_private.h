#pragma once

#include <optional>
#include <string>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

class vtkDataArray;
class vtkDataSet;
class vtkFieldData;

namespace relief::interop {

/// Adds an array of doubles, `components` for each tuple.
void add_doubles(vtkFieldData& data, const char* name, int components,
                 const std::vector<double>& values);

/// The array of that name, with so many components and tuples; null when there is none. kBadInput
/// when it has another size.
Result<vtkDataArray*> find_array(vtkFieldData& data, const char* name, int components,
                                 std::size_t tuples);

/// Name, pose and camera of a view, to and from the field data of a data set.
void write_view_fields(const RangeView& view, vtkDataSet& data);
Result<void> read_pose_fields(vtkDataSet& data, RangeView& view);
/// Nothing when the data set has no camera.
Result<std::optional<Camera>> read_camera_fields(vtkDataSet& data, int width, int height);

}  // namespace relief::interop
