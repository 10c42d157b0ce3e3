#pragma once

#include <string>
#include <vector>

#include "scan/io/image_io.h"
#include "scan/io/view_spec.h"
#include "scan/range_view.h"

namespace relief {

struct NormalMap {
  Grid<Eigen::Vector3f> normals;  ///< As RangeView::normals.
  std::vector<std::string> notes;
};

/// Decodes a normal image for a view whose range is read already and has the image's size. What
/// `spec` leaves out is the convention that agrees best with the normals of the depth; the notes
/// name it. Error (kBadInput) when none agrees. Pixels that hold no direction (length outside
/// [0.5, 1.5]), face away from the sensor or have no sample get NaN.
Result<NormalMap> decode_normals(const Image& image, const NormalSpec& spec, const RangeView& view);

/// Makes the normals of a grid file unit vectors and drops those that are none or face away from
/// the sensor; `file` is for the notes.
NormalMap clean_normals(Grid<Eigen::Vector3f> normals, const RangeView& view,
                        const std::string& file);

/// The axes right, down and forward of the sensor as columns, in the view frame. A reflection for
/// sensors whose frame is left-handed.
Eigen::Matrix3d sensor_axes(const Camera& camera);

}  // namespace relief
