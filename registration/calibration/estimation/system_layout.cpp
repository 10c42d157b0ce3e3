#include "registration/calibration/estimation/system_layout.h"

namespace relief::registration {

SystemLayout::SystemLayout(const Sensors& sensors, const std::vector<bool>& held, bool of_views)
    : per_view(of_views) {
  std::vector<Eigen::Index> of_sensor(sensors.models.size(), -1);
  for (std::size_t i = 0; i < held.size(); ++i) {
    pose.push_back(held[i] ? -1 : poses);
    poses += held[i] ? 0 : 6;
    Eigen::Index& first = of_sensor[sensors.of_view[i]];
    if (per_view || first < 0) {
      first = coefficients;
      coefficients += static_cast<Eigen::Index>(sensors.models[sensors.of_view[i]].terms());
    }
    terms.push_back(first);
  }
}

std::vector<Eigen::Index> SystemLayout::coefficients_of(const ErrorModel& model,
                                                        const ErrorParameter& parameter,
                                                        const Sensors& sensors) const {
  std::vector<Eigen::Index> found;
  for (std::size_t view = 0; view < terms.size(); ++view) {
    if (!model.concerns(parameter, view, sensors)) continue;
    found.push_back(terms[view] + static_cast<Eigen::Index>(parameter.term));
    if (!per_view) break;  // Views of a sensor have the same coefficients.
  }
  return found;
}

std::vector<std::vector<Eigen::Index>> SystemLayout::coefficients_of(const ErrorModel& model,
                                                                     const Sensors& sensors) const {
  std::vector<std::vector<Eigen::Index>> coefficients;
  for (const ErrorParameter& parameter : model.parameters)
    coefficients.push_back(coefficients_of(model, parameter, sensors));
  return coefficients;
}

}  // namespace relief::registration
