#pragma once

#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/simulation/scan_defects.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const ScanDefects& defects);

/// Spoils a view that the sensors measured: warp, glare, outliers, steps, then losses. Lost samples
/// lose their normals too.
void spoil_view(RangeView& view, const ScanDefects& defects, const SensorScene& scene);

/// Turns the components of the view's normals into another convention than the view's frame: the
/// normals are then what a wrong file holds, and may face away from the sensor.
void mistake_normals(RangeView& view, NormalMistake mistake, const RigidMotion& world_from_view);

/// The camera that takes the scans whose camera is said to be `stated`: with the distortion that
/// nobody knows of.
Camera true_camera(const Camera& stated, const ScanDefects& defects);

/// Gives a view the camera `stated`, with a wrong focal length, and ranges with a wrong scale and
/// offset. `spacing`: of the samples [unit].
void miscalibrate(RangeView& view, const Camera& stated, const ScanDefects& defects,
                  double spacing);

}  // namespace relief::simulation
