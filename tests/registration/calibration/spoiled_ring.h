#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "registration/calibration/model/sensor_model.h"
#include "relief/scan/range_view.h"
#include "tests/registration/bumpy_object.h"

namespace relief::testing {

/// Ten views round the object, as a sensor without errors measures it.
inline const std::vector<RangeView>& true_ring() {
  static const std::vector<RangeView> views = ring_of_views({.views = 10, .pixels = 160});
  return views;
}

/// Of its samples.
inline double spacing() {
  static const double value = sample_spacing(true_ring()[0]);
  return value;
}

inline registration::Sensors sensors_of(const std::vector<RangeView>& views) {
  std::vector<const RangeView*> pointers;
  for (const RangeView& view : views) pointers.push_back(&view);
  return registration::find_sensors(pointers, std::vector<double>(views.size(), spacing()));
}

/// What a sensor measures whose error `error` has the coefficients that `coefficient(view, index)`
/// gives for its first terms; from poses that are nearly right.
inline std::vector<RangeView> spoiled(registration::SensorError error,
                                      const std::function<double(std::size_t, int)>& coefficient) {
  std::vector<RangeView> views = true_ring();
  const registration::Sensors sensors = sensors_of(views);
  const registration::SensorModel& model = sensors.models.front();
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::vector<double> coefficients(model.terms(), 0.0);
    for (std::size_t k = 0, index = 0; k < model.terms(); ++k)
      if (model.error_of(k) == error) coefficients[k] = coefficient(i, static_cast<int>(index++));
    views[i].range = model.corrected(views[i], coefficients).range;
  }
  return perturbed(views, Eigen::Vector3d::Zero(), 0.01, 0.5 * spacing());
}

}  // namespace relief::testing
