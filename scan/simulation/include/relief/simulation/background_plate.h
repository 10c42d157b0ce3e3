#pragma once

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/simulation_object.h"

namespace relief::simulation {

/// A flat plate behind the object that stands still before the sensor while the object turns, such
/// as a wall or the bed of a turntable's stand. It fills the image, is white and diffuse.
/// The defaults are choices; docs/results.md has figures with them.
struct BackgroundPlate {
  /// From the object's centre to the plate along the sensor's axis, at the working distance
  /// [diameters]; the plate lies outside of the object's sphere: distance x cos(tilt) > 0.5.
  double distance = 0.75;
  double tilt_deg = 20.0;  ///< Between the plate's normal and the sensor's axis, in [0, 80].

  bool operator==(const BackgroundPlate&) const = default;
};

/// kBadInput names a field out of its range.
Result<void> validate(const BackgroundPlate& plate);

/// Adds the plate to an exact view of `object` wherever nothing lies before it, with its normals;
/// samples steeper than `max_incidence_deg` are left out. Returns which pixels see the plate.
/// `working_distance` and `diameter` [unit] are as in SensorScene.
Grid<unsigned char> add_background(RangeView& view, const SimulationObject& object,
                                   const BackgroundPlate& plate, double working_distance,
                                   double diameter, double max_incidence_deg);

}  // namespace relief::simulation
