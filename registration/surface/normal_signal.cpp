#include "registration/surface/normal_signal.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace relief::registration {

namespace {

// Of the four cells that a coarser one covers.
constexpr int kLeastCells = 3;
constexpr int kMostLevels = 5;  // Cells of the coarsest are 16 pixels wide.

Grid<Eigen::Vector3f> halved(const Grid<Eigen::Vector3f>& fine) {
  Grid<Eigen::Vector3f> coarse(fine.width() / 2, fine.height() / 2,
                               Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (int v = 0; v < coarse.height(); ++v) {
    for (int u = 0; u < coarse.width(); ++u) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector3f& normal = fine(2 * u + k % 2, 2 * v + k / 2);
        if (!normal.allFinite()) continue;
        sum += normal;
        ++count;
      }
      if (count >= kLeastCells) coarse(u, v) = sum.normalized();
    }
  }
  return coarse;
}

}  // namespace

NormalSignal::NormalSignal(const Grid<Eigen::Vector3f>& normals) {
  const int levels = levels_of(normals.width(), normals.height());
  if (levels == 0) return;
  levels_.emplace_back(normals);
  Grid<Eigen::Vector3f> coarse;
  while (this->levels() < levels) {
    coarse = halved(coarse.empty() ? normals : coarse);
    levels_.emplace_back(coarse);
  }
}

int NormalSignal::levels_of(int width, int height) {
  if (width == 0 || height == 0) return 0;
  int levels = 1;
  for (int side = std::min(width, height); levels < kMostLevels && side >= 8; side /= 2) ++levels;
  return levels;
}

std::optional<NormalSample> NormalSignal::at(const Eigen::Vector2d& pixel, int level) const {
  assert(level >= 0 && level < levels());
  const PackedNormals& grid = levels_[static_cast<std::size_t>(level)];
  const double cell = std::ldexp(1.0, level);
  // The centre of cell 0 lies in the middle of the pixels 0 to cell - 1.
  const Eigen::Vector2d place = (pixel.array() - 0.5 * (cell - 1.0)) / cell;
  const double u_floor = std::floor(place.x()), v_floor = std::floor(place.y());
  if (!(u_floor >= 1.0 && v_floor >= 1.0 && u_floor + 2.0 < grid.width() &&
        v_floor + 2.0 < grid.height()))
    return std::nullopt;
  const int u = static_cast<int>(u_floor), v = static_cast<int>(v_floor);
  if (!grid.holds(u - 1, v - 1, u + 2, v + 2)) return std::nullopt;
  const double a = place.x() - u_floor, b = place.y() - v_floor;
  const double weights[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
  Eigen::Vector3d value = Eigen::Vector3d::Zero(), by_u = value, by_v = value;
  for (int k = 0; k < 4; ++k) {
    const int x = u + k % 2, y = v + k / 2;
    for (const auto& [du, dv] : {std::pair{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (!grid(x + du, y + dv).exists()) return std::nullopt;
    value += weights[k] * grid(x, y).scaled();
    by_u += weights[k] * (grid(x + 1, y).scaled() - grid(x - 1, y).scaled());
    by_v += weights[k] * (grid(x, y + 1).scaled() - grid(x, y - 1).scaled());
  }
  NormalSample sample;
  sample.normal = value.normalized();
  const double per_pixel = 0.5 / (cell * PackedNormal::kUnit);
  sample.by_pixel << per_pixel * by_u, per_pixel * by_v;
  return sample;
}

}  // namespace relief::registration
