#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include "relief/scan/grid.h"

namespace relief {

/// A unit normal in six bytes, good to 3e-5 rad, and two bytes for whoever keeps it.
struct PackedNormal {
  static constexpr double kUnit = 32767.0;  ///< The length that stands for 1: 2^15 - 1.

  std::array<std::int16_t, 3> components{};  ///< All zero: there is no normal.
  std::uint16_t note = 0;

  PackedNormal() = default;
  explicit PackedNormal(const Eigen::Vector3f& normal)
      : components{rounded(normal.x()), rounded(normal.y()), rounded(normal.z())} {}

  bool exists() const { return (components[0] | components[1] | components[2]) != 0; }
  /// The normal times kUnit.
  Eigen::Vector3d scaled() const {
    return Eigen::Map<const Eigen::Matrix<std::int16_t, 3, 1>>(components.data()).cast<double>();
  }

 private:
  static std::int16_t rounded(float component) {
    return static_cast<std::int16_t>(std::lround(kUnit * component));
  }
};

/// The normals of a grid, of which only the rectangle that holds any is stored.
class PackedNormals {
 public:
  PackedNormals() = default;
  /// `normals` are unit vectors, NaN where there is none.
  explicit PackedNormals(const Grid<Eigen::Vector3f>& normals);

  int width() const { return width_; }    ///< Of the whole grid.
  int height() const { return height_; }  ///< Of the whole grid.

  /// Whether all pixels from (u0,v0) to (u1,v1) inclusive are stored. Others have no normal.
  bool holds(int u0, int v0, int u1, int v1) const {
    return u0 >= left_ && v0 >= top_ && u1 - left_ < stored_.width() &&
           v1 - top_ < stored_.height();
  }
  const PackedNormal& operator()(int u, int v) const { return stored_(u - left_, v - top_); }
  PackedNormal& operator()(int u, int v) { return stored_(u - left_, v - top_); }

  /// Calls visit(u, v, normal) for all that exist, row by row.
  template <typename Visit>
  void for_each(const Visit& visit) {
    visit_all(*this, visit);
  }
  template <typename Visit>
  void for_each(const Visit& visit) const {
    visit_all(*this, visit);
  }

 private:
  template <typename Normals, typename Visit>
  static void visit_all(Normals& normals, const Visit& visit) {
    auto& stored = normals.stored_;
    for (int v = 0; v < stored.height(); ++v)
      for (int u = 0; u < stored.width(); ++u)
        if (stored(u, v).exists()) visit(u + normals.left_, v + normals.top_, stored(u, v));
  }

  int width_ = 0, height_ = 0, left_ = 0, top_ = 0;
  Grid<PackedNormal> stored_;
};

}  // namespace relief
