#include "relief/scan/discontinuities.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scan/base/median.h"
#include "scan/base/parallel.h"
#include "scan/grid/connected_grid.h"

namespace relief {

namespace {

// The step from one sample to the next along the ray.
struct Step {
  double relative = kNoSample;  // In units of `lateral`: 1 is a slope of 45 degrees.
  double lateral = 0.0;         // Distance between the two rays at the nearer sample [unit].
};

// Without a relative step unless both (u,v) and (u+du,v+dv) have a sample.
Step measure_step(const RangeView& view, int u, int v, int du, int dv) {
  if (!view.has_sample(u, v) || !view.has_sample(u + du, v + dv)) return {};
  const Ray a = view.camera.ray(u, v), b = view.camera.ray(u + du, v + dv);
  const Eigen::Vector3d viewing = a.direction + b.direction;
  const Eigen::Vector3d edge = b.at(view.range(u + du, v + dv)) - a.at(view.range(u, v));
  const double t_near = std::min(view.range(u, v), view.range(u + du, v + dv));
  const Eigen::Vector3d across = b.at(t_near) - a.at(t_near);
  // Both components of what is not normalised have the length of `viewing` as factor.
  const double along = across.dot(viewing);
  const double lateral = std::sqrt(across.squaredNorm() * viewing.squaredNorm() - along * along);
  if (!(lateral > 0.0)) return {};
  return {edge.dot(viewing) / lateral, lateral / viewing.norm()};
}

Grid<float> relative_steps(const RangeView& view, int du, int dv) {
  Grid<float> steps(view.width(), view.height(), static_cast<float>(kNoSample));
  parallel_rows(std::max(0, view.height() - dv), [&](int v) {
    for (int u = 0; u + du < view.width(); ++u)
      steps(u, v) = static_cast<float>(measure_step(view, u, v, du, dv).relative);
  });
  return steps;
}

// Robust standard deviation of one step: the median absolute difference of successive steps, which
// has variance 6 sigma_p^2 for white noise against 2 sigma_p^2 of a step.
double step_noise(const Grid<float>& steps, int du, int dv) {
  std::vector<float> differences;
  for (int v = 0; v + dv < steps.height(); ++v) {
    for (int u = 0; u + du < steps.width(); ++u) {
      const float difference = std::abs(steps(u + du, v + dv) - steps(u, v));
      if (difference == difference) differences.push_back(difference);
    }
  }
  return kSigmaPerMedian * median(differences) / std::numbers::sqrt3;
}

// So many standard deviations of a step are noise; 6e-5 of a Gaussian lies beyond.
constexpr double kNoiseDeviations = 4.0;

// What steps between neighbours the sensor's errors explain.
class StepErrors {
 public:
  StepErrors(const RangeView& view, const RangeNoise& noise) : view_(view), noise_(noise) {}

  // Steps of the range that noise hides are a part of the noise.
  bool rounded() const { return noise_.rounded(); }

  // In units of the lateral distance, round (u,v).
  struct At {
    double noise = 0.0;     // So much may a step be off by noise,
    double rounding = 0.0;  // and by rounding.
  };
  At at(int u, int v, double lateral) const {
    const double sigma = noise_.sigma_at(u, v);
    At errors{kNoiseDeviations * std::numbers::sqrt2 * sigma / lateral, 0.0};
    if (!rounded()) return errors;
    const double metric = view_.camera.ray(u, v).direction.norm();
    const double step = noise_.quantisation.step_at(view_.range(u, v), metric);
    errors.rounding = step / lateral;
    errors.noise *= std::sqrt(std::max(0.0, 1.0 - step * step / (12.0 * sigma * sigma)));
    return errors;
  }

 private:
  const RangeView& view_;
  const RangeNoise& noise_;
};

// The steps between neighbours along one direction, judged one by one.
class StepJudge {
 public:
  StepJudge(const RangeView& view, int du, int dv, const DiscontinuityOptions& options,
            const StepErrors& errors)
      : view_(view),
        errors_(errors),
        steps_(relative_steps(view, du, dv)),
        du_(du),
        dv_(dv),
        limit_(1.0 / std::tan(options.grazing_angle_deg * std::numbers::pi / 180.0)),
        free_step_(options.free_step) {
    // Differences of rounded steps are no noise.
    if (!errors.rounded())
      free_step_ = std::max(free_step_, kNoiseDeviations * step_noise(steps_, du, dv));
    free_step_ = std::min(limit_, free_step_);
  }

  bool connects(int u, int v) const {
    const float step = steps_(u, v);
    const double size = std::abs(step);
    if (!(size == size)) return false;
    if (size <= free_step_) return true;
    const StepErrors::At error = errors_.at(u, v, measure_step(view_, u, v, du_, dv_).lateral);
    if (size <= std::max(free_step_, error.noise) + error.rounding) return true;
    if (size > std::max(limit_, error.noise) + error.rounding) return false;
    return alike(u - du_, v - dv_, step) || alike(u + du_, v + dv_, step) ||
           (errors_.rounded() &&
            (follows_trend(u, v, -1, step, error) || follows_trend(u, v, 1, step, error)));
  }

 private:
  // A neighbouring step explains this one when they differ by less than half of it.
  bool alike(int u, int v, float step) const {
    return steps_.contains(u, v) && std::abs(steps_(u, v) - step) <= 0.5f * std::abs(step);
  }

  // Rounded slopes come as steps of changing size: their mean explains one that it differs from by
  // no more than errors.
  bool follows_trend(int u, int v, int side, double step, const StepErrors::At& error) const {
    // [steps] A sum of rounded steps is off by one rounding at most, the mean of 3 by a third.
    constexpr int kReach = 3;
    double sum = 0.0;
    for (int k = 1; k <= kReach; ++k) {
      const int at_u = u + side * k * du_, at_v = v + side * k * dv_;
      sum += steps_.contains(at_u, at_v) ? double{steps_(at_u, at_v)} : kNoSample;
    }
    return std::abs(step - sum / kReach) <= error.rounding + error.noise;
  }

  const RangeView& view_;
  const StepErrors& errors_;
  Grid<float> steps_;
  int du_, dv_;
  double limit_, free_step_;
};

Grid<std::uint8_t> connect_direction(const RangeView& view, int du, int dv,
                                     const DiscontinuityOptions& options,
                                     const StepErrors& errors) {
  const StepJudge judge(view, du, dv, options, errors);
  Grid<std::uint8_t> connected(view.width(), view.height(), 0);
  parallel_rows(view.height(), [&](int v) {
    for (int u = 0; u < view.width(); ++u) connected(u, v) = judge.connects(u, v);
  });
  return connected;
}

}  // namespace

GridEdges connect_samples(const RangeView& view, const RangeNoise& noise,
                          const DiscontinuityOptions& options) {
  const StepErrors errors(view, noise);
  return {connect_direction(view, 1, 0, options, errors),
          connect_direction(view, 0, 1, options, errors)};
}

GridEdges connect_samples(const RangeView& view, const DiscontinuityOptions& options) {
  return connect_samples(view, estimate_range_noise(view), options);
}

Grid<std::uint8_t> boundary_distance(const RangeView& view, const GridEdges& edges) {
  const int width = view.width(), height = view.height();
  // Pixels on the border of the grid have distance 0, so the others have all their neighbours.
  Grid<std::uint8_t> distance(width, height, 0);
  for (int v = 1; v + 1 < height; ++v)
    for (int u = 1; u + 1 < width; ++u)
      if (edges.right(u, v) && edges.right(u - 1, v) && edges.down(u, v) && edges.down(u, v - 1))
        distance(u, v) = 255;
  const auto relax = [&](int u, int v, int du, int dv) {
    const int next = distance(u + du, v + dv) + 1;
    distance(u, v) = static_cast<std::uint8_t>(std::min<int>(distance(u, v), next));
  };
  for (int v = 1; v + 1 < height; ++v)
    for (int u = 1; u + 1 < width; ++u)
      if (distance(u, v) > 0)
        for (const auto& [du, dv] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}})
          relax(u, v, du, dv);
  for (int v = height - 2; v >= 1; --v)
    for (int u = width - 2; u >= 1; --u)
      if (distance(u, v) > 0)
        for (const auto& [du, dv] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(u, v, du, dv);
  return distance;
}

ConnectedGrid connect_grid(const RangeView& view, const RangeNoise& noise) {
  ConnectedGrid grid;
  grid.points = points_of(view);
  grid.edges = connect_samples(view, noise, {});
  grid.boundary = boundary_distance(view, grid.edges);
  return grid;
}

ConnectedGrid connect_grid(const RangeView& view) {
  return connect_grid(view, estimate_range_noise(view));
}

}  // namespace relief
