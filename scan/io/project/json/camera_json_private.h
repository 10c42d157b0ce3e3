#pragma once

#include <nlohmann/json.hpp>

#include "relief/scan/range_view.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// The numbers of a vector, and the rows of a motion's 4x4 matrix.
nlohmann::ordered_json json_of(const Eigen::Ref<const Eigen::VectorXd>& vector);
nlohmann::ordered_json json_of(const RigidMotion& motion);

/// The distance by which an orthographic camera has to step back so that all its ranges are
/// positive: a depth map cannot hold others. 0 for other cameras.
double step_back(const RangeView& view);

/// The `camera` of a view in a scan.json. An orthographic one stands back by `step_back`. Null for
/// a table of rays that has neither a common direction nor a projection: the reader finds a camera.
nlohmann::ordered_json camera_json(const RangeView& view);

/// The same for a camera as a project describes it.
nlohmann::ordered_json camera_json(const CameraSpec& camera);

}  // namespace relief
