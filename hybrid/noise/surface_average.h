#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"

namespace relief::hybrid {

/// Averages over the surface of a view, weighted by exp(-distance / window) along rows and columns
/// of the grid. Only what hangs together by for_each_bias_pair() is averaged: nothing crosses an
/// occlusion or a hole. Windows of 16 samples and more sum over square cells, of an eighth to a
/// sixteenth of the window along a side, so that they go round small holes and cracks. The cost
/// does not depend on the window, the result not on the number of threads.
class SurfaceAverage {
 public:
  /// `problem` must outlive the object. Windows of up to `largest_window` samples are asked for.
  SurfaceAverage(const ViewProblem& problem, double largest_window);

  /// Of one value per movable sample; `window` in samples, > 0.
  Eigen::VectorXf average(const Eigen::VectorXf& values, double window) const;

  /// How much of the surroundings of each movable sample is surface, with the same weights: 1 far
  /// from borders, about 1/2 at a straight border, 1/4 at a corner.
  Eigen::VectorXf share(double window) const;

 private:
  // The view in square cells of 2^level pixels along a side; level 0 are the pixels. A cell stands
  // for the largest part of its samples that hangs together within it.
  struct Level {
    PaddedGrid grid;
    std::vector<float> samples;             // of each cell
    std::vector<std::uint8_t> right, down;  // 1: hangs together with the next cell
    std::vector<std::uint32_t> coarser;     // cell of the next level that stands for it, or kNone
  };
  struct Place {
    std::size_t level, cell;
  };
  static constexpr std::uint32_t kNone = 0;  // Index 0 is padding.

  static Level coarsened(Level& fine);
  static void choose_largest_parts(Level& fine, const PaddedGrid& coarse);
  static void join_smaller_parts(Level& fine);
  // The coarsest cell, `coarsest` at most, that stands for a pixel.
  Place place_of(std::size_t pixel, std::size_t coarsest) const;

  const ViewProblem& problem_;
  std::vector<Level> levels_;
};

}  // namespace relief::hybrid
