#include "hybrid/view_multigrid.h"

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "hybrid/multigrid.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kRowsAtOnce = 24;
constexpr std::size_t kSamplesAtOnce = 1 << 14;

// Conjugate gradients that reduce the residual by less than this part per step call for a new
// hierarchy once the weights have changed; one made for the weights does better.
constexpr double kSlow = 0.35;

}  // namespace

struct ViewMultigrid::State {
  const ViewProblem& problem;
  bool with_bias;
  int threads;
  EdgeStencil stencil;
  std::optional<Multigrid> multigrid;
  bool slow = false;

  // Of conjugate gradients; `single` and `z` are the preconditioner's input and output.
  Planes<double> residual, direction, image;
  Planes<float> single, z;

  State(const ViewProblem& of, bool bias, int thread_count)
      : problem(of), with_bias(bias), threads(thread_count), stencil(of, bias) {}

  void allocate() {
    const std::size_t size = problem.grid.size();
    if (residual.x.empty()) {
      residual = Planes<double>(size);
      single = z = Planes<float>(size);
    }
    direction = image = Planes<double>(size);
  }
  // Between solves, others need memory as well.
  void release() { direction = image = {}; }

  template <typename Body>
  void each_row(const Body& body) const {
    const auto& spans = stencil.spans();
    parallel_for(spans.size(), kRowsAtOnce, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) body(begin / kRowsAtOnce, spans[v]);
    });
  }
  template <typename Body>
  void each_pixel(const Body& body) const {
    each_row([&](std::size_t, const RowSpan& span) {
      for (std::size_t i = span.begin; i < span.end; ++i) body(i);
    });
  }
  // Calls body(k, i) for every movable sample and its place.
  template <typename Body>
  void each_sample(const Body& body) const {
    parallel_for(problem.size(), kSamplesAtOnce, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        body(static_cast<Eigen::Index>(k), problem.pixels[k]);
    });
  }
  // Sums by pieces of rows in fixed order: the same for any number of threads.
  template <typename Term>
  double sum(const Term& term) const {
    std::vector<double> parts(stencil.spans().size() / kRowsAtOnce + 1, 0.0);
    each_row([&](std::size_t part, const RowSpan& span) {
      double local = 0.0;
      for (std::size_t i = span.begin; i < span.end; ++i) local += term(i);
      parts[part] += local;
    });
    double total = 0.0;
    for (const double part : parts) total += part;
    return total;
  }

  Eigen::Index block() const { return static_cast<Eigen::Index>(problem.size()); }

  void spread(const Eigen::VectorXd& values, Planes<double>& planes) const {
    each_sample([&](Eigen::Index k, std::size_t i) {
      planes.x[i] = values[k];
      if (!with_bias) return;
      planes.bu[i] = values[block() + k];
      planes.bv[i] = values[2 * block() + k];
    });
  }

  // y += step direction
  void advance(double step, Eigen::VectorXd& y) const {
    each_sample([&](Eigen::Index k, std::size_t i) {
      y[k] += step * direction.x[i];
      if (!with_bias) return;
      y[block() + k] += step * direction.bu[i];
      y[2 * block() + k] += step * direction.bv[i];
    });
  }

  // residual += factor image
  void add_image(double factor) {
    each_pixel([&](std::size_t i) {
      residual.x[i] += factor * image.x[i];
      residual.bu[i] += factor * image.bu[i];
      residual.bv[i] += factor * image.bv[i];
    });
  }

  // image = A direction; returns direction . image
  double multiply() {
    const StencilView view = stencil.view();
    const auto in = std::as_const(direction).view();
    each_row([&](std::size_t, const RowSpan& span) {
      apply_row(view, in, span.begin, span.end, image.view());
    });
    return sum([&](std::size_t i) {
      return direction.x[i] * image.x[i] + direction.bu[i] * image.bu[i] +
             direction.bv[i] * image.bv[i];
    });
  }

  // z = M^-1 residual; returns residual . z
  double precondition() {
    each_pixel([&](std::size_t i) {
      single.x[i] = static_cast<float>(residual.x[i]);
      single.bu[i] = static_cast<float>(residual.bu[i]);
      single.bv[i] = static_cast<float>(residual.bv[i]);
    });
    multigrid->apply(single, z);
    return sum([&](std::size_t i) {
      return residual.x[i] * z.x[i] + residual.bu[i] * z.bu[i] + residual.bv[i] * z.bv[i];
    });
  }

  // direction = z + factor direction
  void turn(double factor) {
    each_pixel([&](std::size_t i) {
      direction.x[i] = z.x[i] + factor * direction.x[i];
      direction.bu[i] = z.bu[i] + factor * direction.bu[i];
      direction.bv[i] = z.bv[i] + factor * direction.bv[i];
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

  // Preconditioned conjugate gradients (Hestenes and Stiefel 1952) for the right side that is in
  // `residual`.
  LinearSolve iterate(Eigen::VectorXd& y, double tolerance, int max_iterations) {
    double energy = precondition();
    const double goal = tolerance * tolerance * energy;
    if (!y.isZero(0.0)) {
      spread(y, direction);
      multiply();
      add_image(-1.0);
      energy = precondition();
    }
    const double first = energy;
    double factor = 0.0;
    LinearSolve result;
    while (energy > goal && result.iterations < max_iterations) {
      turn(factor);
      const double step = energy / multiply();
      if (!std::isfinite(step)) break;
      advance(step, y);
      add_image(-step);
      const double next = precondition();
      factor = next / energy;
      energy = next;
      ++result.iterations;
    }
    result.converged = energy <= goal;
    slow = result.iterations > 0 && std::pow(energy / first, 0.5 / result.iterations) > kSlow;
    return result;
  }
};

ViewMultigrid::ViewMultigrid(const ViewProblem& problem, bool with_bias, int threads)
    : state_(std::make_unique<State>(problem, with_bias, threads)) {}
ViewMultigrid::~ViewMultigrid() = default;

bool ViewMultigrid::set_weights(ViewWeights weights) {
  State& s = *state_;
  s.stencil.set_weights(std::move(weights), s.threads);
  if (s.multigrid && !s.slow) {
    s.multigrid->refresh();
    return true;
  }
  s.multigrid.reset();
  s.multigrid.emplace(s.stencil, s.threads);
  s.slow = false;
  return s.multigrid->usable();
}

LinearSolve ViewMultigrid::minimise(Eigen::VectorXd& y, double tolerance, int max_iterations) {
  state_->allocate();
  state_->set_residual_to_objective();
  const LinearSolve result = state_->iterate(y, tolerance, max_iterations);
  state_->release();
  return result;
}

LinearSolve ViewMultigrid::solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& y, double tolerance,
                                 int max_iterations) {
  state_->allocate();
  state_->spread(rhs, state_->residual);
  const LinearSolve result = state_->iterate(y, tolerance, max_iterations);
  state_->release();
  return result;
}

}  // namespace relief
