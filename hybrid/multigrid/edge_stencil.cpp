#include "hybrid/multigrid/edge_stencil.h"

#include <cassert>
#include <utility>

#include <Eigen/Dense>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kRowsAtOnce = 32;  // Of one piece of work; changes no result.

// The diagonal block of pixel i, in double precision.
Eigen::Matrix3d diagonal_block(const StencilView& s, std::ptrdiff_t i) {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  block(0, 0) = s.mass[i];
  block(1, 1) = block(2, 2) = s.bias_size;
  const auto add = [&](const StencilView::Axis& axis, int bias, std::ptrdiff_t edge, double slope,
                       std::ptrdiff_t other) {
    const double weight = axis.weight[edge], half = axis.half_length[edge];
    block(0, 0) += weight * slope * slope;
    block(0, bias) -= weight * slope * half;
    block(bias, 0) -= weight * slope * half;
    block(bias, bias) += weight * half * half;
    if (half <= 0.0) return;
    const double step = double{s.bias_step[i]} * s.bias_step[other];
    block(1, 1) += step;
    block(2, 2) += step;
  };
  add(s.along_u, 1, i, -double{s.along_u.tail[i]}, i + 1);
  add(s.along_u, 1, i - 1, s.along_u.head[i - 1], i - 1);
  add(s.along_v, 2, i, -double{s.along_v.tail[i]}, i + s.stride);
  add(s.along_v, 2, i - s.stride, s.along_v.head[i - s.stride], i - s.stride);
  return block;
}

}  // namespace

EdgeStencil::EdgeStencil(const ViewProblem& problem, bool with_bias) : problem_(problem) {
  assert(problem.slopes.stencil == Stencil::kCompactEdge);
  std::vector<std::uint8_t> movable(problem.grid.size(), 0);
  for (const std::uint32_t i : problem.pixels) movable[i] = 1;
  spans_ = row_spans(problem.grid, movable);
  if (!with_bias) no_length_.assign(problem.grid.size(), 0.0f);
  for (auto& plane : inverse_) plane.assign(problem.grid.size(), 0.0f);
}

void EdgeStencil::set_weights(ViewWeights weights) {
  weights_ = std::move(weights);
  if (!no_length_.empty()) {
    weights_.bias_step.assign(grid().size(), 0.0f);
    weights_.bias_size = 1.0f;
  }
  const StencilView stencil = view();
  parallel_for(spans_.size(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      for (std::size_t i = spans_[v].begin; i < spans_[v].end; ++i) {
        const Eigen::Matrix3d block = diagonal_block(stencil, static_cast<std::ptrdiff_t>(i));
        if (!(block(0, 0) > 0.0)) continue;
        const Eigen::Matrix3d inverse = block.inverse();
        const double values[6] = {inverse(0, 0), inverse(0, 1), inverse(0, 2),
                                  inverse(1, 1), inverse(1, 2), inverse(2, 2)};
        for (int k = 0; k < 6; ++k) inverse_[k][i] = static_cast<float>(values[k]);
      }
    }
  });
}

StencilView EdgeStencil::view() const {
  const auto along = [&](std::size_t axis) {
    const SlopeConstraints::Axis& a = problem_.slopes.axes[axis];
    const std::vector<float>& half_length = no_length_.empty() ? a.half_length : no_length_;
    return StencilView::Axis{a.tail_slope.data(), a.head_slope.data(), half_length.data(),
                             weights_.slope[axis].data()};
  };
  StencilView view{.mass = weights_.position.data(), .along_u = along(0), .along_v = along(1)};
  for (int k = 0; k < 6; ++k) view.inverse[k] = inverse_[k].data();
  view.stride = grid().stride();
  view.bias_step = weights_.bias_step.data();
  view.bias_size = weights_.bias_size;
  return view;
}

}  // namespace relief::hybrid
