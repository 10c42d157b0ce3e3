#pragma once

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/scan_defects.h"
#include "scan/simulation/defects/scan_defects.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const Glare& glare);

/// Spoils a measured view of what `scene.truth` shows. A plate behind the object is not glossy.
void add_glare(RangeView& view, const Glare& glare, const SensorScene& scene);

}  // namespace relief::simulation
