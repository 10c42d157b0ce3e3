#pragma once

#include <cstddef>

#include "hybrid/model/view_problem.h"
#include "hybrid/noise/noise.h"
#include "hybrid/noise/range_deviation.h"
#include "relief/hybrid/refine_view.h"

namespace relief::hybrid {

/// The errors of a view in the form that the weights of equation (H5) need.
struct NoiseModel {
  double sigma_position = 0.0;   ///< Of a range along its ray [unit].
  double sigma_normal = 0.0;     ///< Of a normal's slope [rad].
  double sigma_bias_step = 0.0;  ///< Of the change of the bias between neighbours [rad].
  double spacing = 0.0;          ///< Between samples, on the surface [unit].
  double slope_share = 1.0;      ///< Variance of a slope constraint, in (length sigma_normal)^2.
  MeasurementNoise measured;     ///< What the measurements are like, whatever they are weighted by.

  bool usable() const { return sigma_position > 0.0 && sigma_normal > 0.0; }
  /// The wavelength / 2 pi at which the errors of positions and normals cross [samples].
  double crossover() const { return sigma_position / (spacing * sigma_normal); }
};

/// What `options` give, completed by what was estimated.
NoiseModel make_noise_model(const RefineOptions& options, const NoiseEstimate& estimate,
                            const ViewProblem& problem);

/// The ratio of the noises in the terms of the published method.
double equivalent_lambda(const NoiseModel& noise);

}  // namespace relief::hybrid
