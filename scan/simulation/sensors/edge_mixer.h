#pragma once

#include "relief/scan/discontinuities.h"
#include "scan/base/counter_random.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// Which samples beside an occlusion edge see both of its sides: pixels across an edge average.
class EdgeMixer {
 public:
  /// `fraction` of the samples beside an edge of `scene.truth`, in [0, 1].
  EdgeMixer(double fraction, const SensorScene& scene);

  /// How much of the neighbour across the edge a pixel sees, and the neighbour's range.
  struct Mixture {
    double share = 0.0;  ///< In [0, 0.5); 0: the pixel sees its own side only.
    double other = 0.0;  ///< [unit]; the pixel's own range where the share is 0.
  };
  Mixture at(int u, int v) const;

 private:
  double fraction_;
  const RangeView& truth_;
  GridEdges edges_;
  CounterRandom random_;
};

}  // namespace relief::simulation
