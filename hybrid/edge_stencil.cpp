#include "hybrid/edge_stencil.h"

#include <Eigen/Dense>

#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kRowsAtOnce = 32;

// The diagonal block of pixel i, in double precision.
Eigen::Matrix3d diagonal_block(const EdgeStencil& s, std::size_t i) {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  block(0, 0) = s.mass[i];
  block(1, 1) = block(2, 2) = s.bias_size;
  const auto add = [&](const EdgeStencil::Axis& axis, int bias, std::size_t edge, double slope) {
    const double weight = axis.weight[edge], half = axis.half_length[edge];
    block(0, 0) += weight * slope * slope;
    block(0, bias) -= weight * slope * half;
    block(bias, 0) -= weight * slope * half;
    block(bias, bias) += weight * half * half;
    if (half <= 0.0) return;
    block(1, 1) += s.bias_step;
    block(2, 2) += s.bias_step;
  };
  const auto stride = static_cast<std::size_t>(s.grid.stride());
  add(s.along_u, 1, i, -static_cast<double>(s.along_u.tail[i]));
  add(s.along_u, 1, i - 1, s.along_u.head[i - 1]);
  add(s.along_v, 2, i, -static_cast<double>(s.along_v.tail[i]));
  add(s.along_v, 2, i - stride, s.along_v.head[i - stride]);
  return block;
}

}  // namespace

EdgeStencil::EdgeStencil(PaddedGrid padded) : grid(padded), mass(padded.size(), 0.0f) {
  for (Axis* axis : {&along_u, &along_v})
    for (auto* plane : {&axis->tail, &axis->head, &axis->half_length, &axis->weight})
      plane->assign(padded.size(), 0.0f);
  for (auto& plane : inverse_) plane.assign(padded.size(), 0.0f);
}

void EdgeStencil::find_spans(const std::vector<std::uint8_t>& movable) {
  spans.assign(static_cast<std::size_t>(grid.height), {});
  for (int v = 0; v < grid.height; ++v) {
    Span& span = spans[static_cast<std::size_t>(v)];
    const std::uint32_t first = grid.index(0, v);
    span = {first, first};
    for (int u = 0; u < grid.width; ++u) {
      const std::uint32_t i = grid.index(u, v);
      if (!movable[i]) continue;
      if (span.begin == span.end) span.begin = i;
      span.end = i + 1;
    }
  }
}

void EdgeStencil::invert_blocks(int threads) {
  parallel_for(spans.size(), kRowsAtOnce, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      for (std::size_t i = spans[v].begin; i < spans[v].end; ++i) {
        const Eigen::Matrix3d block = diagonal_block(*this, i);
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
  const auto of = [](const Axis& axis) {
    return StencilView::Axis{axis.tail.data(), axis.head.data(), axis.half_length.data(),
                             axis.weight.data()};
  };
  StencilView view{.mass = mass.data(), .along_u = of(along_u), .along_v = of(along_v)};
  for (int k = 0; k < 6; ++k) view.inverse[k] = inverse_[k].data();
  view.stride = grid.stride();
  view.bias_step = bias_step;
  view.bias_size = bias_size;
  return view;
}

}  // namespace relief
