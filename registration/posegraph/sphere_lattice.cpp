#include "registration/posegraph/sphere_lattice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>

#include "scan/base/cell_key.h"

namespace relief::registration {

namespace {

using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

// Relative to the coordinates: far more than the rounding of a motion and a distance, and far less
// than a sample spacing.
constexpr double kRounding = 1e-12;

// The power of two of which a reach is between half and the whole.
int octave_of(double reach) {
  int exponent = 0;
  std::frexp(reach, &exponent);
  return exponent;
}

// Spheres of one octave by the cells of their centres.
class Lattice {
 public:
  explicit Lattice(double edge) : edge_(edge) {}

  void add(std::size_t sphere, const Eigen::Vector3d& centre) {
    members_.push_back(sphere);
    const Cell cell = cell_of(centre);
    cells_[cell_key(cell.x(), cell.y(), cell.z())].push_back(sphere);
  }

  // Calls visit(sphere) for those with centres within `reach` of a point along each axis, and for
  // some others.
  template <typename Visit>
  void for_near(const Eigen::Vector3d& point, double reach, const Visit& visit) const {
    // More cells than spheres: all are asked. So a cell key is never met twice either.
    if (std::pow(2.0 * reach / edge_ + 2.0, 3) >= static_cast<double>(members_.size())) {
      for (const std::size_t sphere : members_) visit(sphere);
      return;
    }
    const Cell low = cell_of(point.array() - reach), high = cell_of(point.array() + reach);
    for (std::int64_t z = low.z(); z <= high.z(); ++z)
      for (std::int64_t y = low.y(); y <= high.y(); ++y)
        for (std::int64_t x = low.x(); x <= high.x(); ++x)
          if (const auto found = cells_.find(cell_key(x, y, z)); found != cells_.end())
            for (const std::size_t sphere : found->second) visit(sphere);
  }

  double edge() const { return edge_; }

 private:
  Cell cell_of(const Eigen::Vector3d& point) const {
    return (point / edge_).array().floor().cast<std::int64_t>();
  }

  double edge_;
  std::vector<std::size_t> members_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> near_spheres(const std::vector<Sphere>& spheres,
                                                              double margin) {
  if (spheres.empty()) return {};
  // Relative to one of them: a lattice far from the origin would lose digits.
  const Eigen::Vector3d origin = spheres.front().centre;
  double largest = 0.0;
  for (const Sphere& sphere : spheres)
    largest = std::max(largest, sphere.centre.cwiseAbs().maxCoeff() + sphere.radius);
  const double rounding = kRounding * (largest + margin) + 1e-300;
  const auto reach_of = [&](const Sphere& sphere) { return sphere.radius + margin + rounding; };

  std::map<int, Lattice> lattices;  // By octave of the reach.
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const int octave = octave_of(reach_of(spheres[i]));
    lattices.try_emplace(octave, std::ldexp(1.0, octave))
        .first->second.add(i, spheres[i].centre - origin);
  }
  Pairs pairs;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const int own = octave_of(reach_of(spheres[i]));
    for (const auto& [octave, lattice] : lattices) {
      if (octave > own) break;  // The larger sphere asks.
      const double reach = reach_of(spheres[i]) + lattice.edge();
      lattice.for_near(spheres[i].centre - origin, reach, [&, octave = octave](std::size_t j) {
        if (octave == own && j >= i) return;
        const double limit = spheres[i].radius + spheres[j].radius + margin + rounding;
        if ((spheres[i].centre - spheres[j].centre).norm() <= limit)
          pairs.push_back(std::minmax(i, j));
      });
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace relief::registration
