#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A symmetric matrix of 6x6 blocks, most of them zero: those with row <= column.
using SymmetricBlocks = std::map<std::pair<std::size_t, std::size_t>, Matrix6d>;

/// The diagonal blocks of A^-1 B A^-1, the sandwich of (R12), without rows and columns of views
/// that are `left_out`: theirs are zero. Every other view has a diagonal block in `a`. Nothing
/// where A is not positive definite by more than rounding makes of it.
///
/// A Cholesky factorisation of blocks in the order of least degree, then the blocks of the inverse
/// on its pattern alone (Takahashi, Fagan and Chen 1973). Both carry derivatives along: those of
/// (A - e B)^-1 by e at 0 are what is asked for. Time and memory follow the factor's fill: for
/// views over a surface they grow about as the number of views. All blocks of the inverse would be
/// its square.
std::optional<std::vector<Matrix6d>> sandwich_diagonal(const SymmetricBlocks& a,
                                                       const SymmetricBlocks& b,
                                                       const std::vector<bool>& left_out);

}  // namespace relief::registration
