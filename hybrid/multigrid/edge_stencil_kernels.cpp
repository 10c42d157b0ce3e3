// No header of Eigen here: its alignment must not follow the wider vectors that these loops use.
#include "hybrid/multigrid/edge_stencil_kernels.h"

#include <algorithm>

// Compiled twice, the better version chosen when the program starts. Without contraction to fused
// multiply-adds both give the same bytes. Sanitizers do not bear the choice at start-up.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RELIEF_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define RELIEF_CLONES
#endif
#define RELIEF_INLINE inline __attribute__((always_inline))

namespace relief::hybrid {

namespace {

// Pixels whose products, 12 KiB in double precision, fit the innermost cache.
constexpr std::ptrdiff_t kChunk = 512;

template <typename T>
struct Products {
  alignas(64) T x[kChunk], bu[kChunk], bv[kChunk];
};

// A sum in a fixed number of lanes, so that its order does not depend on the width of vectors.
class LaneSums {
 public:
  RELIEF_INLINE void add(const float* __restrict a, const double* __restrict b,
                         std::ptrdiff_t count) {
    std::ptrdiff_t i = 0;
    for (; i + kLanes <= count; i += kLanes)
      for (std::ptrdiff_t k = 0; k < kLanes; ++k) lanes_[k] += double{a[i + k]} * b[i + k];
    for (; i < count; ++i) lanes_[0] += double{a[i]} * b[i];
  }
  double total() const {
    double sum = 0.0;
    for (const double lane : lanes_) sum += lane;
    return sum;
  }

 private:
  static constexpr std::ptrdiff_t kLanes = 8;  // Sums side by side, whatever the processor.
  double lanes_[kLanes] = {};
};

// Products of A for pixels [begin, begin + count), equation (H5) differentiated: every edge pulls
// at its two ends with its weighted residual.
template <typename T>
RELIEF_INLINE void multiply(const StencilView& s, PlanesView<const float> in, std::ptrdiff_t begin,
                            std::ptrdiff_t count, Products<T>& out) {
  const std::ptrdiff_t below = s.stride;
  const float* __restrict mass = s.mass + begin;
  const float* __restrict tu = s.along_u.tail + begin;
  const float* __restrict hu = s.along_u.head + begin;
  const float* __restrict lu = s.along_u.half_length + begin;
  const float* __restrict wu = s.along_u.weight + begin;
  const float* __restrict tv = s.along_v.tail + begin;
  const float* __restrict hv = s.along_v.head + begin;
  const float* __restrict lv = s.along_v.half_length + begin;
  const float* __restrict wv = s.along_v.weight + begin;
  const float* __restrict x_in = in.x + begin;
  const float* __restrict bu_in = in.bu + begin;
  const float* __restrict bv_in = in.bv + begin;
  const float* __restrict step = s.bias_step + begin;
  const T size = s.bias_size;
  // As a factor: with a branch for each neighbour the compiler does not vectorise the loop.
  const auto joined = [](float half_length) __attribute__((always_inline)) {
    return half_length > 0.0f ? T(1) : T(0);
  };
  const auto x = [=](std::ptrdiff_t i) __attribute__((always_inline)) { return T(x_in[i]); };
  const auto bu = [=](std::ptrdiff_t i) __attribute__((always_inline)) { return T(bu_in[i]); };
  const auto bv = [=](std::ptrdiff_t i) __attribute__((always_inline)) { return T(bv_in[i]); };
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const T right = wu[i] * (hu[i] * x(i + 1) - tu[i] * x(i) - lu[i] * (bu(i) + bu(i + 1)));
    const T left =
        wu[i - 1] * (hu[i - 1] * x(i) - tu[i - 1] * x(i - 1) - lu[i - 1] * (bu(i - 1) + bu(i)));
    const T down = wv[i] * (hv[i] * x(i + below) - tv[i] * x(i) - lv[i] * (bv(i) + bv(i + below)));
    const T up = wv[i - below] * (hv[i - below] * x(i) - tv[i - below] * x(i - below) -
                                  lv[i - below] * (bv(i - below) + bv(i)));
    out.x[i] =
        mass[i] * x(i) - tu[i] * right + hu[i - 1] * left - tv[i] * down + hv[i - below] * up;
    // The bias is smooth between samples that share a constraint.
    const T here = step[i];
    const T to_right = joined(lu[i]) * (here * step[i + 1]);
    const T to_left = joined(lu[i - 1]) * (here * step[i - 1]);
    const T to_down = joined(lv[i]) * (here * step[i + below]);
    const T to_up = joined(lv[i - below]) * (here * step[i - below]);
    out.bu[i] = size * bu(i) - lu[i] * right - lu[i - 1] * left + to_right * (bu(i) - bu(i + 1)) +
                to_left * (bu(i) - bu(i - 1)) + to_down * (bu(i) - bu(i + below)) +
                to_up * (bu(i) - bu(i - below));
    out.bv[i] = size * bv(i) - lv[i] * down - lv[i - below] * up + to_right * (bv(i) - bv(i + 1)) +
                to_left * (bv(i) - bv(i - 1)) + to_down * (bv(i) - bv(i + below)) +
                to_up * (bv(i) - bv(i - below));
  }
}

}  // namespace

RELIEF_CLONES double energy_row(const StencilView& s, PlanesView<const float> in,
                                std::ptrdiff_t begin, std::ptrdiff_t end) {
  Products<double> product;
  LaneSums sums;
  for (std::ptrdiff_t first = begin; first < end; first += kChunk) {
    const std::ptrdiff_t count = std::min(kChunk, end - first);
    multiply<double>(s, in, first, count, product);
    sums.add(in.x + first, product.x, count);
    sums.add(in.bu + first, product.bu, count);
    sums.add(in.bv + first, product.bv, count);
  }
  return sums.total();
}

RELIEF_CLONES void subtract_row(const StencilView& s, double c, PlanesView<const float> in,
                                std::ptrdiff_t begin, std::ptrdiff_t end, PlanesView<double> r,
                                PlanesView<float> rounded) {
  Products<double> product;
  for (std::ptrdiff_t first = begin; first < end; first += kChunk) {
    const std::ptrdiff_t count = std::min(kChunk, end - first);
    multiply<double>(s, in, first, count, product);
    const auto subtract = [&](const double* __restrict subtrahend, double* __restrict rest,
                              float* __restrict single) __attribute__((always_inline)) {
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        rest[i] -= c * subtrahend[i];
        single[i] = static_cast<float>(rest[i]);
      }
    };
    subtract(product.x, r.x + first, rounded.x + first);
    subtract(product.bu, r.bu + first, rounded.bu + first);
    subtract(product.bv, r.bv + first, rounded.bv + first);
  }
}

RELIEF_CLONES double dot_row(PlanesView<const double> a, PlanesView<const float> b,
                             std::ptrdiff_t begin, std::ptrdiff_t end) {
  LaneSums sums;
  sums.add(b.x + begin, a.x + begin, end - begin);
  sums.add(b.bu + begin, a.bu + begin, end - begin);
  sums.add(b.bv + begin, a.bv + begin, end - begin);
  return sums.total();
}

RELIEF_CLONES void residual_row(const StencilView& s, PlanesView<const float> r, float c,
                                PlanesView<const float> in, std::ptrdiff_t begin,
                                std::ptrdiff_t end, PlanesView<float> out) {
  Products<float> product;
  for (std::ptrdiff_t first = begin; first < end; first += kChunk) {
    const std::ptrdiff_t count = std::min(kChunk, end - first);
    multiply<float>(s, in, first, count, product);
    for (std::ptrdiff_t i = 0; i < count; ++i) out.x[first + i] = r.x[first + i] + c * product.x[i];
    for (std::ptrdiff_t i = 0; i < count; ++i)
      out.bu[first + i] = r.bu[first + i] + c * product.bu[i];
    for (std::ptrdiff_t i = 0; i < count; ++i)
      out.bv[first + i] = r.bv[first + i] + c * product.bv[i];
  }
}

RELIEF_CLONES void relax_row(const StencilView& s, float g, float a, PlanesView<const float> in,
                             float b, PlanesView<const float> r, std::ptrdiff_t begin,
                             std::ptrdiff_t end, PlanesView<float> out) {
  Products<float> product;
  for (std::ptrdiff_t first = begin; first < end; first += kChunk) {
    const std::ptrdiff_t count = std::min(kChunk, end - first);
    multiply<float>(s, in, first, count, product);
    if (r.x) {
      for (std::ptrdiff_t i = 0; i < count; ++i) product.x[i] = r.x[first + i] - product.x[i];
      for (std::ptrdiff_t i = 0; i < count; ++i) product.bu[i] = r.bu[first + i] - product.bu[i];
      for (std::ptrdiff_t i = 0; i < count; ++i) product.bv[i] = r.bv[first + i] - product.bv[i];
    } else {
      for (std::ptrdiff_t i = 0; i < count; ++i) product.x[i] = -product.x[i];
      for (std::ptrdiff_t i = 0; i < count; ++i) product.bu[i] = -product.bu[i];
      for (std::ptrdiff_t i = 0; i < count; ++i) product.bv[i] = -product.bv[i];
    }
    const float* __restrict xx = s.inverse[0] + first;
    const float* __restrict xu = s.inverse[1] + first;
    const float* __restrict xv = s.inverse[2] + first;
    const float* __restrict uu = s.inverse[3] + first;
    const float* __restrict uv = s.inverse[4] + first;
    const float* __restrict vv = s.inverse[5] + first;
    const auto combine = [&](const float* __restrict p0, const float* __restrict p1,
                             const float* __restrict p2, const float* __restrict input,
                             float* __restrict output) __attribute__((always_inline)) {
      for (std::ptrdiff_t i = 0; i < count; ++i)
        output[i] = g * output[i] + a * input[i] +
                    b * (p0[i] * product.x[i] + p1[i] * product.bu[i] + p2[i] * product.bv[i]);
    };
    combine(xx, xu, xv, in.x + first, out.x + first);
    combine(xu, uu, uv, in.bu + first, out.bu + first);
    combine(xv, uv, vv, in.bv + first, out.bv + first);
  }
}

RELIEF_CLONES void scale_row(const StencilView& s, float b, PlanesView<const float> r,
                             std::ptrdiff_t begin, std::ptrdiff_t end, PlanesView<float> out) {
  const auto combine = [&](const float* __restrict p0, const float* __restrict p1,
                           const float* __restrict p2, float* __restrict output)
      __attribute__((always_inline)) {
    for (std::ptrdiff_t i = begin; i < end; ++i)
      output[i] = b * (p0[i] * r.x[i] + p1[i] * r.bu[i] + p2[i] * r.bv[i]);
  };
  combine(s.inverse[0], s.inverse[1], s.inverse[2], out.x);
  combine(s.inverse[1], s.inverse[3], s.inverse[4], out.bu);
  combine(s.inverse[2], s.inverse[4], s.inverse[5], out.bv);
}

}  // namespace relief::hybrid
