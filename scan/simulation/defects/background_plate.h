#pragma once

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/scan_defects.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/defects/scan_defects.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const BackgroundPlate& plate);

/// Adds the plate to an exact view of `object` wherever nothing lies before it, with its normals;
/// samples steeper than `max_incidence_deg` are left out. Returns which pixels see the plate.
/// `working_distance` and `diameter` [unit] are as in SensorScene.
Grid<unsigned char> add_background(RangeView& view, const SimulationObject& object,
                                   const BackgroundPlate& plate, double working_distance,
                                   double diameter, double max_incidence_deg);

}  // namespace relief::simulation
