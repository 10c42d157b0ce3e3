#pragma once

#include "relief/scan/result.h"
#include "relief/simulation/sensor_scene.h"

namespace relief::simulation {

/// Highlights of lamps that stand still before the sensor, on an object that is glossy all over.
/// They wander over the object from view to view and spoil range and normals. The defaults
/// are choices; docs/results.md has figures with them.
struct Glare {
  int lamps = 2;                 ///< Evenly on a cone round the viewing axis, in [1, 64].
  double lamp_angle_deg = 30.0;  ///< Between the lamps and the viewing axis, in (0, 90).
  /// Angle between the normal and the half vector of lamp and viewer at which a highlight has
  /// fallen to 1/e [degrees], in (0, 90).
  double width_deg = 6.0;
  /// Standard deviation of the range error in the middle of a highlight [sample spacings], >= 0; it
  /// is alike over three pixels.
  double range_error = 3.0;

  bool operator==(const Glare&) const = default;
};

/// kBadInput names a field out of its range.
Result<void> validate(const Glare& glare);

/// Spoils a measured view of what `scene.truth` shows. A plate behind the object is not glossy.
void add_glare(RangeView& view, const Glare& glare, const SensorScene& scene);

}  // namespace relief::simulation
