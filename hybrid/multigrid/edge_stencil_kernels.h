#pragma once

#include <cstddef>

namespace relief::hybrid {

/// The coefficients of an EdgeStencil as bare pointers, for loops that the compiler can vectorise.
/// All planes have padding: the pixels left, right, above and below of any pixel exist in memory.
struct StencilView {
  const float* mass = nullptr;
  struct Axis {
    const float *tail = nullptr, *head = nullptr, *half_length = nullptr, *weight = nullptr;
  } along_u, along_v;
  const float* inverse[6] = {};  // xx, xu, xv, uu, uv, vv of the inverse diagonal blocks
  std::ptrdiff_t stride = 0;
  const float* bias_step = nullptr;  // Of a sample: pairs weigh the product of both.
  float bias_size = 0.0f;
};

/// Three planes, one per unknown of a pixel.
template <typename T>
struct PlanesView {
  T *x = nullptr, *bu = nullptr, *bv = nullptr;
};

// The loops of the multigrid solver over the pixels [begin, end) of one row. A is the matrix of the
// stencil, D its diagonal blocks. `out` may be `r`, but not `in`.

/// in . A in, worked out in double precision.
double energy_row(const StencilView& stencil, PlanesView<const float> in, std::ptrdiff_t begin,
                  std::ptrdiff_t end);
/// r = r - c A in, worked out in double precision; rounded = r.
void subtract_row(const StencilView& stencil, double c, PlanesView<const float> in,
                  std::ptrdiff_t begin, std::ptrdiff_t end, PlanesView<double> r,
                  PlanesView<float> rounded);
/// a . b.
double dot_row(PlanesView<const double> a, PlanesView<const float> b, std::ptrdiff_t begin,
               std::ptrdiff_t end);
/// out = r + c A in.
void residual_row(const StencilView& stencil, PlanesView<const float> r, float c,
                  PlanesView<const float> in, std::ptrdiff_t begin, std::ptrdiff_t end,
                  PlanesView<float> out);
/// out = g out + a in + b D^-1 (r - A in); r may be null for zero.
void relax_row(const StencilView& stencil, float g, float a, PlanesView<const float> in, float b,
               PlanesView<const float> r, std::ptrdiff_t begin, std::ptrdiff_t end,
               PlanesView<float> out);
/// out = b D^-1 r.
void scale_row(const StencilView& stencil, float b, PlanesView<const float> r, std::ptrdiff_t begin,
               std::ptrdiff_t end, PlanesView<float> out);

}  // namespace relief::hybrid
