#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"

namespace relief::hybrid {

/// Averages over the surface of a view, weighted by exp(-distance / window) along rows and columns
/// of the grid. Only what hangs together by for_each_bias_pair() is averaged: nothing crosses an
/// occlusion or a hole. The cost does not depend on the window, the result not on the number of
/// threads.
class SurfaceAverage {
 public:
  /// `problem` must outlive the object.
  explicit SurfaceAverage(const ViewProblem& problem);

  /// Of one value per movable sample; `window` in samples, > 0.
  Eigen::VectorXf average(const Eigen::VectorXf& values, double window) const;

  /// How much of the surroundings of each movable sample is surface, with the same weights: 1 far
  /// from borders, about 1/2 at a straight border, 1/4 at a corner.
  Eigen::VectorXf share(double window) const;

 private:
  template <typename Sum>
  void sum_up(std::vector<Sum>& plane, double window) const;
  template <typename Sum>
  void sum_row(std::size_t first, float decay, std::vector<Sum>& plane) const;
  template <typename Sum>
  void sum_columns(std::size_t begin, std::size_t end, float decay, std::vector<Sum>& plane) const;

  const ViewProblem& problem_;
  std::vector<std::uint8_t> right_, down_;  // padded; 1: hangs together with the next pixel
};

}  // namespace relief::hybrid
