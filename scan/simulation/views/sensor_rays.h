#pragma once

#include "relief/scan/camera.h"
#include "relief/scan/rigid_motion.h"
#include "relief/simulation/simulate.h"

namespace relief::simulation {

/// A sensor whose axis meets the centre of the image. `focal` [pixels] is the working distance over
/// `spacing` [unit], the side of a pixel at the working distance. A spherical sensor has its step
/// from `width` instead.
Camera sensor_camera(SensorRays rays, int width, int height, double focal, double spacing);

/// The motion from the frame of such a sensor to x right, y down, z forward: the identity but for
/// kSpherical.
RigidMotion optical_from_sensor(SensorRays rays);

}  // namespace relief::simulation
