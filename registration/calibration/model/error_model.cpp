#include "registration/calibration/model/error_model.h"

#include <algorithm>

namespace relief::registration {

void ErrorModel::add(const ErrorChoice& choice, const Sensors& sensors) {
  const std::size_t owners = choice.per_view ? sensors.of_view.size() : sensors.models.size();
  for (std::size_t owner = 0; owner < owners; ++owner) {
    const std::size_t sensor = choice.per_view ? sensors.of_view[owner] : owner;
    for (std::size_t k = 0; k < sensors.models[sensor].terms(); ++k)
      if (sensors.models[sensor].error_of(k) == choice.error)
        parameters.push_back({choices.size(), owner, k, 0.0});
  }
  choices.push_back(choice);
}

bool ErrorModel::has(const ErrorChoice& choice) const {
  return std::find(choices.begin(), choices.end(), choice) != choices.end();
}

bool ErrorModel::concerns(const ErrorParameter& parameter, std::size_t view,
                          const Sensors& sensors) const {
  return parameter.owner == (choices[parameter.choice].per_view ? view : sensors.of_view[view]);
}

std::vector<double> ErrorModel::coefficients(std::size_t view, const Sensors& sensors) const {
  std::vector<double> sum(sensors.models[sensors.of_view[view]].terms(), 0.0);
  for (const ErrorParameter& parameter : parameters)
    if (concerns(parameter, view, sensors)) sum[parameter.term] += parameter.value;
  return sum;
}

double take_median_scale(ErrorModel& model, const Sensors& sensors) {
  const auto scale = std::find_if(
      model.choices.begin(), model.choices.end(),
      [](const ErrorChoice& choice) { return choice.error == SensorError::kRangeScale; });
  const bool free = std::all_of(sensors.models.begin(), sensors.models.end(),
                                [](const SensorModel& sensor) { return sensor.scales_all(); });
  if (scale == model.choices.end() || !free) return 0.0;
  std::vector<double> ratios;
  for (std::size_t view = 0; view < sensors.of_view.size(); ++view) {
    const SensorModel& sensor = sensors.models[sensors.of_view[view]];
    const std::vector<double> coefficients = model.coefficients(view, sensors);
    for (std::size_t k = 0; k < sensor.terms(); ++k)
      if (sensor.error_of(k) == SensorError::kRangeScale)
        ratios.push_back(sensor.natural(k, coefficients[k]));
  }
  std::sort(ratios.begin(), ratios.end());
  const double median = 0.5 * (ratios[(ratios.size() - 1) / 2] + ratios[ratios.size() / 2]);
  const auto choice = static_cast<std::size_t>(scale - model.choices.begin());
  for (ErrorParameter& parameter : model.parameters) {
    if (parameter.choice != choice) continue;
    const std::size_t sensor = scale->per_view ? sensors.of_view[parameter.owner] : parameter.owner;
    const double unit = sensors.models[sensor].natural(parameter.term, 1.0);
    if (unit > 0.0) parameter.value -= median / unit;
  }
  return median;
}

}  // namespace relief::registration
