#include "hybrid/multigrid/view_multigrid.h"

#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "hybrid/multigrid/multigrid.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kRowsAtOnce = 24;  // Of one piece of work; sums run in fixed order.

// Part of the residual that a step leaves at least when changed weights call for a new hierarchy.
// That costs six to nine steps and leaves 0.25 (docs/results.md, Refining one view, by size).
constexpr double kSlow = 0.35;

// The part of the error that is left in x which a preconditioned residual shows at least. Measured:
// Multigrid.TheDefaultToleranceIsTheErrorOfTheRange. Half of it costs half a step.
constexpr double kErrorShown = 0.3;

}  // namespace

struct ViewMultigrid::State {
  const ViewProblem& problem;
  bool with_bias;
  EdgeStencil stencil;
  std::optional<Multigrid> multigrid;
  bool slow = false;
  std::optional<double> energy_at_zero;  // of the objective, by the preconditioner

  // Of conjugate gradients. The direction is rounded to single precision before anything is
  // computed from it, so that the residual stays that of the solution. `single`, the rounded
  // residual, and `z` are the preconditioner's input and output.
  Planes<double> residual;
  Planes<float> direction, single, z;

  State(const ViewProblem& of, bool bias) : problem(of), with_bias(bias), stencil(of, bias) {}

  void allocate() {
    if (!residual.x.empty()) return;
    const std::size_t size = problem.grid.size();
    residual = Planes<double>(size);
    direction = single = z = Planes<float>(size);
  }

  template <typename Body>
  void each_row(const Body& body) const {
    const auto& spans = stencil.spans();
    parallel_for(spans.size(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) body(spans[v]);
    });
  }
  template <typename Body>
  void each_pixel(const Body& body) const {
    each_row([&](const RowSpan& span) {
      for (std::size_t i = span.begin; i < span.end; ++i) body(i);
    });
  }
  // The sum of term(row span).
  template <typename Term>
  double sum(const Term& term) const {
    const auto& spans = stencil.spans();
    const auto sum_of = [&](std::size_t begin, std::size_t end) {
      double part = 0.0;
      for (std::size_t v = begin; v < end; ++v) part += term(spans[v]);
      return part;
    };
    return parallel_sum(spans.size(), kRowsAtOnce, 0.0, sum_of);
  }

  Eigen::Index block() const { return static_cast<Eigen::Index>(problem.size()); }
  int blocks() const { return with_bias ? 3 : 1; }

  // planes = part(value) of the movable samples
  template <typename T, typename Part>
  void spread(const Eigen::VectorXd& values, const Part& part, Planes<T>& planes) const {
    std::vector<T>* const plane[] = {&planes.x, &planes.bu, &planes.bv};
    for_each_sample(problem, [&](Eigen::Index k, std::size_t i) {
      for (int b = 0; b < blocks(); ++b)
        (*plane[b])[i] = static_cast<T>(part(values[b * block() + k]));
    });
  }

  // y += step direction
  void advance(double step, Eigen::VectorXd& y) const {
    const std::vector<float>* const plane[] = {&direction.x, &direction.bu, &direction.bv};
    for_each_sample(problem, [&](Eigen::Index k, std::size_t i) {
      for (int b = 0; b < blocks(); ++b) y[b * block() + k] += step * (*plane[b])[i];
    });
  }

  // direction . A direction
  double curvature() const {
    const StencilView view = stencil.view();
    return sum([&](const RowSpan& span) {
      return energy_row(view, direction.view(), span.begin, span.end);
    });
  }

  // residual -= factor A direction
  void subtract_image(double factor) {
    const StencilView view = stencil.view();
    each_row([&](const RowSpan& span) {
      subtract_row(view, factor, std::as_const(direction).view(), span.begin, span.end,
                   residual.view(), single.view());
    });
  }

  // residual -= A y, to double precision although directions are single.
  void subtract_image_of(const Eigen::VectorXd& y) {
    const auto rounded = [](double value) { return static_cast<float>(value); };
    spread(y, rounded, direction);
    subtract_image(1.0);
    spread(
        y, [&](double value) { return value - rounded(value); }, direction);
    subtract_image(1.0);
  }

  void round_residual() {
    each_pixel([&](std::size_t i) {
      single.x[i] = static_cast<float>(residual.x[i]);
      single.bu[i] = static_cast<float>(residual.bu[i]);
      single.bv[i] = static_cast<float>(residual.bv[i]);
    });
  }

  // z = M^-1 residual, about the error of the solution; returns residual . z
  double precondition() {
    multigrid->apply(single, z);
    return sum([&](const RowSpan& span) {
      return dot_row(std::as_const(residual).view(), std::as_const(z).view(), span.begin, span.end);
    });
  }

  // |x|^2 of the error that the preconditioned residual shows
  double squared_error() const {
    return sum([&](const RowSpan& span) {
      double squares = 0.0;
      for (std::size_t i = span.begin; i < span.end; ++i) squares += double{z.x[i]} * z.x[i];
      return squares;
    });
  }

  // direction = z + factor direction
  void turn(double factor) {
    const auto blend = [&](const std::vector<float>& from, std::vector<float>& to, std::size_t i) {
      to[i] = static_cast<float>(from[i] + factor * to[i]);
    };
    each_pixel([&](std::size_t i) {
      blend(z.x, direction.x, i);
      blend(z.bu, direction.bu, i);
      blend(z.bv, direction.bv, i);
    });
  }

  // residual = the right side of the normal equations: minus the constraints' steps, weighted.
  void set_residual_to_objective() {
    const StencilView s = stencil.view();
    const float* step_u = problem.slopes.axes[0].step.data();
    const float* step_v = problem.slopes.axes[1].step.data();
    each_pixel([&](std::size_t place) {
      const auto i = static_cast<std::ptrdiff_t>(place), left = i - 1, up = i - s.stride;
      const auto pull = [](const StencilView::Axis& axis, const float* step, std::ptrdiff_t k) {
        return double{axis.weight[k]} * double{step[k]};
      };
      const double to_right = pull(s.along_u, step_u, i), to_left = pull(s.along_u, step_u, left);
      const double to_down = pull(s.along_v, step_v, i), to_up = pull(s.along_v, step_v, up);
      residual.x[place] = to_right * s.along_u.tail[i] - to_left * s.along_u.head[left] +
                          to_down * s.along_v.tail[i] - to_up * s.along_v.head[up];
      residual.bu[place] =
          to_right * s.along_u.half_length[i] + to_left * s.along_u.half_length[left];
      residual.bv[place] = to_down * s.along_v.half_length[i] + to_up * s.along_v.half_length[up];
    });
  }

  // Preconditioned conjugate gradients (Hestenes and Stiefel 1952) from `y`, whose residual is in
  // `residual`, until the energy of the residual is at most `goal` and the error of x at most
  // `tolerance`. What the last preconditioned residual shows of the error is taken away as well.
  LinearSolve iterate(Eigen::VectorXd& y, double energy, double goal, double tolerance,
                      int max_iterations) {
    const auto converged = [&] {
      return energy <= goal && squared_error() <= std::pow(kErrorShown * tolerance, 2) *
                                                      y.head(block()).squaredNorm();
    };
    const double first = energy;
    double factor = 0.0;
    LinearSolve result;
    while (!(result.converged = converged()) && result.iterations < max_iterations) {
      turn(factor);
      const double step = energy / curvature();
      if (!std::isfinite(step)) break;
      advance(step, y);
      subtract_image(step);
      factor = 1.0 / energy;
      energy = precondition();
      factor *= energy;
      ++result.iterations;
    }
    if (result.converged) {
      turn(0.0);
      advance(1.0, y);
    }
    slow = result.iterations > 0 && std::pow(energy / first, 0.5 / result.iterations) > kSlow;
    return result;
  }
};

ViewMultigrid::ViewMultigrid(const ViewProblem& problem, bool with_bias)
    : state_(std::make_unique<State>(problem, with_bias)) {}
ViewMultigrid::~ViewMultigrid() = default;

bool ViewMultigrid::set_weights(ViewWeights weights) {
  State& s = *state_;
  s.stencil.set_weights(std::move(weights));
  if (s.multigrid && !s.slow) {
    s.multigrid->refresh();
    return true;
  }
  s.multigrid.reset();
  s.multigrid.emplace(s.stencil);
  s.slow = false;
  return s.multigrid->usable();
}

LinearSolve ViewMultigrid::minimise(Eigen::VectorXd& y, double tolerance, int max_iterations) {
  State& s = *state_;
  s.allocate();
  s.set_residual_to_objective();
  s.round_residual();
  // Reweighting changes the energy at y = 0 too little to find it again.
  const bool at_zero = y.isZero(0.0);
  double energy = at_zero || !s.energy_at_zero ? s.precondition() : 0.0;
  if (!s.energy_at_zero) s.energy_at_zero = energy;
  if (!at_zero) {
    s.subtract_image_of(y);
    energy = s.precondition();
  }
  const double goal = tolerance * tolerance * *s.energy_at_zero;
  return s.iterate(y, energy, goal, tolerance, max_iterations);
}

LinearSolve ViewMultigrid::solve(Eigen::VectorXd& y, double tolerance, int max_iterations) {
  State& s = *state_;
  s.allocate();
  s.spread(y, std::identity(), s.residual);
  s.round_residual();
  y.setZero();
  const double energy = s.precondition();
  return s.iterate(y, energy, tolerance * tolerance * energy, tolerance, max_iterations);
}

}  // namespace relief::hybrid
