#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/normal_sensors.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const PhotometricStereo& camera);

/// Unit directions towards the lights in the view frame (x right, y down, z forward).
std::vector<Eigen::Vector3d> light_directions(const PhotometricStereo& camera);

/// The distortion A = I + E of the normals, equation (S13), for which E has the stated RMS angle.
Eigen::Matrix3d normal_distortion(const PhotometricStereo& camera, const RandomStream& random);

/// Replaces the exact normals of `view`, which are those of `scene.truth`, by what the camera
/// measures.
void scan_by_shading(RangeView& view, const PhotometricStereo& camera, const SensorScene& scene);

}  // namespace relief::simulation
