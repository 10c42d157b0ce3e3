#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/result.h"
#include "scan/io/clouds/cloud_rays.h"
#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// Puts the points of a cloud into the cells of a lattice of rays, about one into each. The cloud
/// outlives this. Call fit(), then place_points(), then what asks for the result.
class CloudCells {
 public:
  CloudCells(const PointCloudFile& cloud, const CloudRays& rays);

  /// Finds the lattice; errors are those of fit_lattice().
  Result<void> fit();
  void place_points();

  /// The points in their cells, with the camera of the rays.
  GridFile grid() const;
  /// The largest distance between neighbouring places at a distance from the sensor [unit].
  double spacing(double distance) const;

  std::size_t kept() const;                         ///< Points that have a cell.
  std::size_t shared() const { return shared_; }    ///< Without one as another has it.
  std::size_t hidden() const { return hidden_; }    ///< Behind others.
  std::size_t outside() const { return outside_; }  ///< Beyond the lattice.

 private:
  struct Place {
    std::int32_t u = 0, v = 0;
    float off_u = 0.0f, off_v = 0.0f;  // From the middle of the cell, in steps.
  };

  void end_at_poles();
  void close_turn();
  void find_places();
  std::size_t end_of_cell(std::size_t begin) const;
  float off_centre(std::uint32_t point) const;
  void place_cell(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& crowded);
  bool move_beside(std::uint32_t point);
  int nearer_neighbours(int u, int v) const;
  void drop_what_shows_through();

  const PointCloudFile& cloud_;
  CloudRays rays_;
  CloudLattice lattice_;
  bool goes_round_ = false;  // The column after the last one is the first.
  std::vector<Eigen::Vector3d> projected_;
  std::vector<Place> places_;
  std::vector<std::uint32_t> order_;  // Points inside the lattice, cell by cell.
  Grid<std::uint32_t> owner_;         // The point of each cell.
  std::size_t shared_ = 0, hidden_ = 0, outside_ = 0;
};

}  // namespace relief
