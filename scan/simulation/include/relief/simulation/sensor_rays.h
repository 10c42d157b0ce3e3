#pragma once

#include "relief/scan/camera.h"

namespace relief::simulation {

/// How the rays of a simulated sensor run. View frame: x right, y down, z forward; the range of a
/// sample is its depth z.
enum class SensorRays {
  kPinhole,       ///< Through one point.
  kOrthographic,  ///< Parallel.
  kLine,  ///< Of a line scanner that moves along x: parallel from column to column, and within a
          ///< column through one point (the linear pushbroom camera of Gupta and Hartley 1997).
};

/// A sensor whose axis meets the centre of the image. `focal` [pixels] is the working distance over
/// `spacing` [unit], the side of a pixel at the working distance.
Camera sensor_camera(SensorRays rays, int width, int height, double focal, double spacing);

}  // namespace relief::simulation
