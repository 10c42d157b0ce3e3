#pragma once

#include "relief/scan/camera.h"
#include "relief/scan/rigid_motion.h"

namespace relief::simulation {

/// How the rays of a simulated sensor run. View frame: x right, y down, z forward; the range of a
/// sample is its depth z.
enum class SensorRays {
  kPinhole,       ///< Through one point.
  kOrthographic,  ///< Parallel.
  kLine,  ///< Of a line scanner that moves along x: parallel from column to column, and within a
          ///< column through one point (the linear pushbroom camera of Gupta and Hartley 1997).
  kSpherical,  ///< Of a scanner that turns round its axis: whole turns of azimuth, and elevations
               ///< as far up and down as the rows allow at the same step. Here z of the view frame
               ///< is the axis and points up, x is forward, and the range is the distance.
};

/// A sensor whose axis meets the centre of the image. `focal` [pixels] is the working distance over
/// `spacing` [unit], the side of a pixel at the working distance. A spherical sensor has its step
/// from `width` instead.
Camera sensor_camera(SensorRays rays, int width, int height, double focal, double spacing);

/// The motion from the frame of such a sensor to x right, y down, z forward: the identity but for
/// kSpherical.
RigidMotion optical_from_sensor(SensorRays rays);

}  // namespace relief::simulation
