#include "hybrid/noise/noise_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hybrid/noise/constraint_median.h"

namespace relief::hybrid {

namespace {

// A pair of neighbouring normals, averaged, errs by cos(w / 2) times what one does at the frequency
// w [rad per sample]: all of it over long waves, half of the variance on average. What counts is
// where positions and normals cross; normals that rule at all frequencies share no more than half.
double share_of_averaged_normals(const NoiseModel& noise) {
  const double crossover = noise.spacing * noise.sigma_normal / noise.sigma_position;
  return std::max(0.5, std::pow(std::cos(0.5 * std::min(std::numbers::pi, crossover)), 2));
}

// The random walk whose power sigma_b^2 / frequency^2 best explains a bias of RMS change
// `gradient`: the squared changes are shared among the frequencies at which the bias exceeds the
// other errors,
//   sigma_b^2 = gradient^2 / (share of those frequencies),
// found by iteration. At least the walk that meets the noise of the normals where they and the
// positions cross: a larger one costs little, a smaller one leaves bias in the range.
double default_bias_step(const NoiseModel& noise, double gradient) {
  const double position = noise.sigma_position / noise.spacing;
  const double crossover = std::min(1.0, noise.sigma_normal / position);  // [rad per sample]
  double sigma = noise.sigma_normal * crossover;
  const double least = sigma;
  for (int round = 0; round < 30; ++round) {
    const double normal = noise.sigma_normal * noise.sigma_normal;
    // sigma^2 / w^2 = normal + w^2 position^2, a quadratic in w^2
    const double squared_frequency =
        2.0 * sigma * sigma /
        (normal + std::sqrt(normal * normal + 4.0 * position * position * sigma * sigma));
    const double share = std::min(1.0, squared_frequency / (4.0 * std::numbers::pi));
    sigma = std::max(least, std::numbers::sqrt2 * gradient / std::sqrt(share));
  }
  return sigma;
}

}  // namespace

NoiseModel make_noise_model(const RefineOptions& options, const NoiseEstimate& estimate,
                            const ViewProblem& problem) {
  NoiseModel noise;
  noise.spacing = 2.0 * median_over_constraints(problem, [&](std::size_t axis, std::size_t i) {
                    return problem.slopes.axes[axis].half_length[i];
                  });
  noise.sigma_position = options.sigma_position.value_or(estimate.sigma_position);
  noise.sigma_normal = options.sigma_normal.value_or(estimate.sigma_normal);
  // Normals that rule over more samples than there are could as well be that much less precise.
  if (!options.sigma_normal && estimate.enough())
    noise.sigma_normal = std::max(
        noise.sigma_normal,
        noise.sigma_position / (noise.spacing * std::sqrt(static_cast<double>(problem.size()))));
  // E_p / sigma_p^2 + E_n / (l sigma_n)^2 is the published sum up to a factor.
  if (options.lambda)
    noise.sigma_normal =
        noise.sigma_position / noise.spacing * std::sqrt(*options.lambda / (1.0 - *options.lambda));
  else if (options.stencil == Stencil::kCompactEdge)
    noise.slope_share = share_of_averaged_normals(noise);
  noise.sigma_bias_step =
      options.sigma_bias_step.value_or(default_bias_step(noise, estimate.bias_gradient));
  noise.measured = {noise.sigma_position, noise.sigma_normal};
  if (options.lambda && estimate.sigma_normal > 0.0)
    noise.measured.sigma_normal = estimate.sigma_normal;
  return noise;
}

double equivalent_lambda(const NoiseModel& noise) {
  const double step = noise.spacing * noise.sigma_normal;
  const double variance = noise.slope_share * step * step;
  return variance / (noise.sigma_position * noise.sigma_position + variance);
}

}  // namespace relief::hybrid
