#include "hybrid/view_multigrid.h"

#include <cassert>
#include <cmath>
#include <optional>
#include <vector>

#include "hybrid/multigrid.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kRowsAtOnce = 24;

}  // namespace

struct ViewMultigrid::State {
  const ViewProblem& problem;
  bool with_bias;
  int threads;
  EdgeStencil stencil;
  std::vector<std::uint32_t> place;  // padded index of every movable sample
  std::optional<Multigrid> multigrid;

  State(const ViewProblem& of, int width, int height, bool bias, int thread_count)
      : problem(of), with_bias(bias), threads(thread_count), stencil(PaddedGrid{width, height}) {
    std::vector<std::uint8_t> movable(stencil.grid.size(), 0);
    for (const std::uint32_t pixel : problem.pixels) {
      const int u = static_cast<int>(pixel) % width, v = static_cast<int>(pixel) / width;
      place.push_back(stencil.grid.index(u, v));
      movable[place.back()] = 1;
    }
    stencil.find_spans(movable);
    for (const SlopeConstraint& c : problem.slopes) {
      EdgeStencil::Axis& axis = c.axis == 0 ? stencil.along_u : stencil.along_v;
      const std::uint32_t i = place[c.tail];
      axis.tail[i] = c.tail_slope;
      axis.head[i] = c.head_slope;
      axis.half_length[i] = with_bias ? 0.5f * c.length : 0.0f;
    }
  }

  template <typename Body>
  void each_rows(const Body& body) const {
    parallel_for(stencil.spans.size(), kRowsAtOnce, threads,
                 [&](std::size_t begin, std::size_t end) {
                   for (std::size_t v = begin; v < end; ++v)
                     body(begin / kRowsAtOnce, stencil.spans[v]);
                 });
  }

  // Sums by pieces of rows in fixed order: the same for any number of threads.
  template <typename Term>
  double sum(const Term& term) const {
    std::vector<double> parts((stencil.spans.size() + kRowsAtOnce - 1) / kRowsAtOnce, 0.0);
    each_rows([&](std::size_t part, const EdgeStencil::Span& span) {
      double local = 0.0;
      for (std::size_t i = span.begin; i < span.end; ++i) local += term(i);
      parts[part] += local;
    });
    double total = 0.0;
    for (const double part : parts) total += part;
    return total;
  }

  Planes<double> padded(const Eigen::VectorXd& values) const {
    Planes<double> planes(stencil.grid.size());
    const auto count = static_cast<Eigen::Index>(place.size());
    for (Eigen::Index k = 0; k < count; ++k) {
      planes.x[place[static_cast<std::size_t>(k)]] = values[k];
      if (!with_bias) continue;
      planes.bu[place[static_cast<std::size_t>(k)]] = values[count + k];
      planes.bv[place[static_cast<std::size_t>(k)]] = values[2 * count + k];
    }
    return planes;
  }
  void unpad(const Planes<double>& planes, Eigen::VectorXd& values) const {
    const auto count = static_cast<Eigen::Index>(place.size());
    for (Eigen::Index k = 0; k < count; ++k) {
      values[k] = planes.x[place[static_cast<std::size_t>(k)]];
      if (!with_bias) continue;
      values[count + k] = planes.bu[place[static_cast<std::size_t>(k)]];
      values[2 * count + k] = planes.bv[place[static_cast<std::size_t>(k)]];
    }
  }

  void multiply(const Planes<double>& in, Planes<double>& out) const {
    const StencilView view = stencil.view();
    each_rows([&](std::size_t, const EdgeStencil::Span& span) {
      apply_row(view, in.view(), span.begin, span.end, out.view());
    });
  }

  // z = M^-1 r; returns r . z
  double precondition(const Planes<double>& r, Planes<float>& single, Planes<float>& z) {
    each_rows([&](std::size_t, const EdgeStencil::Span& span) {
      for (std::size_t i = span.begin; i < span.end; ++i) {
        single.x[i] = static_cast<float>(r.x[i]);
        single.bu[i] = static_cast<float>(r.bu[i]);
        single.bv[i] = static_cast<float>(r.bv[i]);
      }
    });
    multigrid->apply(single, z);
    return sum(
        [&](std::size_t i) { return r.x[i] * z.x[i] + r.bu[i] * z.bu[i] + r.bv[i] * z.bv[i]; });
  }
};

ViewMultigrid::ViewMultigrid(const ViewProblem& problem, bool with_bias, int threads)
    : state_(std::make_unique<State>(problem, problem.width, problem.height, with_bias, threads)) {
  assert(problem.stencil == Stencil::kCompactEdge);
}
ViewMultigrid::~ViewMultigrid() = default;

bool ViewMultigrid::set_weights(const ViewWeights& weights) {
  State& s = *state_;
  const auto count = static_cast<Eigen::Index>(s.problem.size());
  for (Eigen::Index k = 0; k < count; ++k)
    s.stencil.mass[s.place[static_cast<std::size_t>(k)]] = weights.position[k];
  rhs_ = Eigen::VectorXd::Zero((s.with_bias ? 3 : 1) * count);
  for (std::size_t k = 0; k < s.problem.slopes.size(); ++k) {
    const SlopeConstraint& c = s.problem.slopes[k];
    const double weight = weights.slope[static_cast<Eigen::Index>(k)];
    EdgeStencil::Axis& axis = c.axis == 0 ? s.stencil.along_u : s.stencil.along_v;
    axis.weight[s.place[c.tail]] = weights.slope[static_cast<Eigen::Index>(k)];
    rhs_[c.tail] += weight * c.step * c.tail_slope;
    rhs_[c.head] -= weight * c.step * c.head_slope;
    if (!s.with_bias) continue;
    for (const std::uint32_t at : c.at)
      rhs_[(1 + c.axis) * count + at] += weight * c.step * 0.5 * c.length;
  }
  s.stencil.bias_step = s.with_bias ? weights.bias_step : 0.0f;
  s.stencil.bias_size = s.with_bias ? weights.bias_size : 1.0f;
  s.stencil.invert_blocks(s.threads);
  s.multigrid.reset();
  s.multigrid.emplace(s.stencil, s.threads);
  return s.multigrid->usable();
}

// Preconditioned conjugate gradients (Hestenes and Stiefel 1952).
LinearSolve ViewMultigrid::solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& y, double tolerance,
                                 int max_iterations) {
  State& s = *state_;
  const std::size_t size = s.stencil.grid.size();
  Planes<float> single(size), z(size);
  Planes<double> residual = s.padded(rhs), solution = s.padded(y), direction(size), image(size);
  const double goal = tolerance * tolerance * s.precondition(residual, single, z);
  s.multiply(solution, image);
  const auto each_pixel = [&](const auto& body) {
    s.each_rows([&](std::size_t, const EdgeStencil::Span& span) {
      for (std::size_t i = span.begin; i < span.end; ++i) body(i);
    });
  };
  each_pixel([&](std::size_t i) {
    residual.x[i] -= image.x[i];
    residual.bu[i] -= image.bu[i];
    residual.bv[i] -= image.bv[i];
  });
  LinearSolve result;
  double energy = s.precondition(residual, single, z), factor = 0.0;
  while (energy > goal && result.iterations < max_iterations) {
    each_pixel([&](std::size_t i) {
      direction.x[i] = z.x[i] + factor * direction.x[i];
      direction.bu[i] = z.bu[i] + factor * direction.bu[i];
      direction.bv[i] = z.bv[i] + factor * direction.bv[i];
    });
    s.multiply(direction, image);
    const double curvature = s.sum([&](std::size_t i) {
      return direction.x[i] * image.x[i] + direction.bu[i] * image.bu[i] +
             direction.bv[i] * image.bv[i];
    });
    const double step = energy / curvature;
    if (!std::isfinite(step)) break;
    each_pixel([&](std::size_t i) {
      solution.x[i] += step * direction.x[i];
      solution.bu[i] += step * direction.bu[i];
      solution.bv[i] += step * direction.bv[i];
      residual.x[i] -= step * image.x[i];
      residual.bu[i] -= step * image.bu[i];
      residual.bv[i] -= step * image.bv[i];
    });
    const double next = s.precondition(residual, single, z);
    factor = next / energy;
    energy = next;
    ++result.iterations;
  }
  result.converged = energy <= goal;
  s.unpad(solution, y);
  return result;
}

}  // namespace relief
