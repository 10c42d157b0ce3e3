#pragma once

#include <memory>

#include "hybrid/multigrid/edge_stencil.h"

namespace relief::hybrid {

/// One V-cycle of multigrid by smoothed aggregation for the matrix of an EdgeStencil: a symmetric
/// positive definite approximation of its inverse. Groups of 3 x 3 samples move as rigid pieces
/// (displacement and two slopes) on the next coarser level; groups never span what is not
/// connected. Relaxation is by two Chebyshev steps on the 3 x 3 blocks of each sample: symmetric,
/// and the same whatever the number of threads. The finest level is in single precision and never
/// stored as a matrix, coarser ones are in double.
class Multigrid {
 public:
  /// `stencil` must outlive the object and have weights.
  explicit Multigrid(const EdgeStencil& stencil);
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;

  /// False when the coarsest matrix could not be factorised.
  bool usable() const;
  int levels() const;
  /// To be called when the stencil's weights have changed. The finest level follows them; coarser
  /// ones stay as they were made.
  void refresh();
  /// x = approximately A^-1 r.
  void apply(const Planes<float>& r, Planes<float>& x);

 private:
  struct Hierarchy;
  std::unique_ptr<Hierarchy> hierarchy_;
};

}  // namespace relief::hybrid
