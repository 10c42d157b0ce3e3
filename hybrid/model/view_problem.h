#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/model/slope_constraints.h"
#include "relief/scan/range_view.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

/// How much the range of each sample of a view counts, 1 for nominal: its confidence or, where its
/// deviation is known, the inverse of its variance against that of the median deviation.
class PositionConfidence {
 public:
  /// `view` must outlive the object.
  explicit PositionConfidence(const RangeView& view);

  /// >= 0; infinite deviations count as 0.
  float operator()(int u, int v) const;
  /// The deviation of a sample that counts 1 [unit]; 0 when the view knows none.
  float nominal_deviation() const { return nominal_; }

 private:
  const RangeView& view_;
  float nominal_;
};

/// What refining a view minimises, before weights: the samples that can move and the constraints
/// between them. Vectors of unknowns are [x; b_u; b_v] in the order of `pixels`, or x alone without
/// a bias.
struct ViewProblem {
  PaddedGrid grid;
  std::vector<std::uint32_t> pixels;  ///< Padded index of every movable sample, ascending.
  /// PositionConfidence of every movable sample; each component has some > 0.
  Eigen::VectorXf confidence;
  SlopeConstraints slopes;      ///< Between movable samples only.
  std::size_t constraints = 0;  ///< Number of those.
  /// Central stencil: neighbours on the surface, both with normals; indices count movable samples.
  /// With the compact one, neighbours are those that share a constraint: see bias_neighbours.
  std::vector<std::array<std::uint32_t, 2>> central_neighbours;
  std::size_t pinned = 0;  ///< Samples that keep their measured range.

  std::size_t size() const { return pixels.size(); }
  bool empty() const { return constraints == 0; }
};

/// Movable are the samples that a normal constrains and whose connected component holds at least
/// one sample of positive confidence; all others keep their measured range and constrain nothing.
ViewProblem make_view_problem(const RangeView& view, const GridEdges& edges, Stencil stencil);

/// Calls body(k, pixels[k]) for every movable sample, in parallel.
template <typename Body>
void for_each_sample(const ViewProblem& problem, const Body& body) {
  constexpr std::size_t kSamplesAtOnce = 1 << 14;  // Of one piece of work; changes no result.
  parallel_for(problem.size(), kSamplesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) body(static_cast<Eigen::Index>(k), problem.pixels[k]);
  });
}

/// Place in `pixels` by padded index; the largest value of the type where nothing moves.
std::vector<std::uint32_t> numbers_of(const ViewProblem& problem);

/// Pairs of movable samples between which the bias is smooth.
std::vector<std::array<std::uint32_t, 2>> bias_neighbours(const ViewProblem& problem);

/// Calls visit(a, b) with the padded indices of each of these pairs. With the compact stencil, in
/// parallel as SlopeConstraints::parallel_for_each does.
template <typename Visit>
void for_each_bias_pair(const ViewProblem& problem, const Visit& visit) {
  for (const auto& [a, b] : problem.central_neighbours) visit(problem.pixels[a], problem.pixels[b]);
  if (problem.slopes.stencil == Stencil::kPaperCentral) return;
  problem.slopes.parallel_for_each([&](int axis, std::size_t i) {
    const SlopeConstraints::Ends ends = problem.slopes.ends(axis, i);
    visit(ends.at0, ends.at1);
  });
}

/// The weights of the terms of equation (H5), each the inverse of a variance. Planes are padded.
struct ViewWeights {
  std::vector<float> position;              ///< Per movable sample [1/unit^2]; else zero.
  std::array<std::vector<float>, 2> slope;  ///< Per slope constraint [1/unit^2]; else zero.
  /// Per movable sample, for the change of the bias between neighbours [1/rad]: the weight of a
  /// pair is the product of both. Else zero.
  std::vector<float> bias_step;
  float bias_size = 0.0f;  ///< Of the bias itself [1/rad^2]; keeps islands determined.

  double bias_step_between(std::size_t a, std::size_t b) const {
    return double{bias_step[a]} * bias_step[b];
  }
};

/// Residual of every slope constraint [unit] at `y`, by axis, padded; zero elsewhere.
std::array<std::vector<float>, 2> slope_residuals(const ViewProblem& problem,
                                                  const Eigen::VectorXd& y);

}  // namespace relief::hybrid
