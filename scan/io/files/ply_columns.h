#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "scan/io/files/ply_file.h"

namespace relief {

/// The values of three scalar properties, which belong together. They live in the PlyElement.
using PlyColumns = std::array<const PagedVector<double>*, 3>;

/// Nothing unless `element` has all three, as scalars.
inline std::optional<PlyColumns> ply_columns(const PlyElement& element,
                                             const std::array<const char*, 3>& names) {
  PlyColumns columns{};
  for (std::size_t k = 0; k < 3; ++k) {
    const PlyProperty* property = element.find(names[k]);
    if (!property || property->is_list) return std::nullopt;
    columns[k] = &property->values;
  }
  return columns;
}

/// The three values of instance `i`.
inline Eigen::Vector3d ply_vector(const PlyColumns& columns, std::size_t i) {
  return {(*columns[0])[i], (*columns[1])[i], (*columns[2])[i]};
}

}  // namespace relief
