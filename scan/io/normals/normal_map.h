#pragma once

#include <optional>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"
#include "scan/io/images/image_io.h"
#include "scan/io/normals/convention_choice.h"
#include "scan/io/normals/normal_evidence.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Decodes a normal image for a view whose range is read already and has the image's size. What
/// `spec` says of the convention is recorded in the evidence, not yet applied. kBadInput for an
/// image of one channel, and for world space without a pose.
Result<StoredNormals> stored_in_image(const Image& image, const NormalSpec& spec,
                                      const RangeView& view);

/// The normals of a grid file, in any length, stated to be in the axes of the file.
StoredNormals stored_in_grid(Grid<Eigen::Vector3f> normals, const std::filesystem::path& file,
                             const RangeView& view);

/// Turns stored normals into those of `view`: unit vectors in its frame. Pixels that hold no
/// direction (length outside [0.5, 1.5]) or face away from the sensor get NaN. Pixels without a
/// sample keep their normals: small gaps of the range are filled with them. No normals at all if
/// they are not usable. Returns notes on what was dropped.
std::vector<std::string> apply_convention(const StoredNormals& stored,
                                          const ChosenConvention& chosen, RangeView& view);

/// The axes right, down and forward of the sensor as columns, in the view frame. A reflection for
/// sensors whose frame is left-handed.
Eigen::Matrix3d sensor_axes(const Camera& camera);

}  // namespace relief
