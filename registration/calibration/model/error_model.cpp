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

}  // namespace relief::registration
