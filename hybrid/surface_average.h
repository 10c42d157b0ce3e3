#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "hybrid/view_problem.h"
#include "scan/grid.h"

namespace relief {

/// Averages over the surface of a view, weighted by exp(-distance / window) along rows and columns
/// of the grid. Only what hangs together by bias_neighbours() is averaged: nothing crosses an
/// occlusion or a hole. The cost does not depend on the window, the result not on the number of
/// threads.
class SurfaceAverage {
 public:
  /// `problem` must outlive the object. `threads`: 0 is one per core.
  SurfaceAverage(const ViewProblem& problem, int threads);

  /// Of one value per movable sample; `window` in samples, > 0.
  Eigen::VectorXd average(const Eigen::VectorXd& values, double window) const;

  /// How much of the surroundings of each movable sample is surface, with the same weights: 1 far
  /// from borders, about 1/2 at a straight border, 1/4 at a corner.
  Eigen::VectorXd share(double window) const;

 private:
  // What is summed at a pixel, and the weight of that sum.
  struct Sum {
    double value = 0.0, weight = 0.0;
    Sum operator+(const Sum& other) const { return {value + other.value, weight + other.weight}; }
    Sum times(double factor) const { return {factor * value, factor * weight}; }
  };

  Grid<Sum> sums(const Eigen::VectorXd& values, double window) const;
  void sum_row(int v, double decay, Grid<Sum>& sums) const;
  void sum_columns(int begin, int end, double decay, Grid<Sum>& before, Grid<Sum>& sums) const;
  template <typename Value>
  Eigen::VectorXd each_sample(const Grid<Sum>& sums, const Value& value) const;

  const ViewProblem& problem_;
  int threads_;
  Grid<std::uint8_t> right_, down_;  // 1: hangs together with the next pixel
};

}  // namespace relief
