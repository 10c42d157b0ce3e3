#include "hybrid/model/view_system.h"

#include <algorithm>
#include <cassert>

namespace relief::hybrid {

ViewSystem::ViewSystem(const ViewProblem& problem, bool with_bias)
    : problem_(problem),
      with_bias_(with_bias),
      samples_(static_cast<Eigen::Index>(problem.size())),
      number_(numbers_of(problem)),
      neighbours_(bias_neighbours(problem)) {
  find_pattern();
}

// The residual of a constraint is step + coefficients . unknowns.
ViewSystem::Row ViewSystem::row_of(int axis, std::size_t i) const {
  const SlopeConstraints::Axis& a = problem_.slopes.axes[static_cast<std::size_t>(axis)];
  const SlopeConstraints::Ends ends = problem_.slopes.ends(axis, i);
  const Eigen::Index bias = (1 + axis) * samples_;
  return {
      {number_[ends.tail], number_[ends.head], bias + number_[ends.at0], bias + number_[ends.at1]},
      {-double{a.tail_slope[i]}, a.head_slope[i], -double{a.half_length[i]},
       -double{a.half_length[i]}}};
}

void ViewSystem::find_pattern() {
  const Eigen::Index size = blocks() * samples_;
  std::vector<Eigen::Triplet<double>> places;
  const auto touch = [&](Eigen::Index i, Eigen::Index j) {
    places.emplace_back(std::max(i, j), std::min(i, j), 0.0);
  };
  for (Eigen::Index i = 0; i < size; ++i) touch(i, i);
  problem_.slopes.for_each([&](int axis, std::size_t i) {
    const Row row = row_of(axis, i);
    for (int a = 0; a < terms(); ++a)
      for (int b = 0; b < a; ++b) touch(row.unknown[a], row.unknown[b]);
  });
  if (with_bias_)
    for (const auto& [a, b] : neighbours_)
      for (const int block : {1, 2}) touch(block * samples_ + a, block * samples_ + b);
  lower_.resize(size, size);
  lower_.setFromTriplets(places.begin(), places.end());

  problem_.slopes.for_each([&](int axis, std::size_t i) {
    const Row row = row_of(axis, i);
    for (int a = 0; a < terms(); ++a)
      for (int b = 0; b <= a; ++b) slope_slots_.push_back(slot(row.unknown[a], row.unknown[b]));
  });
  if (with_bias_)
    for (const auto& [a, b] : neighbours_)
      for (const int block : {1, 2})
        smooth_slots_.push_back(slot(block * samples_ + a, block * samples_ + b));
}

std::uint32_t ViewSystem::slot(Eigen::Index i, Eigen::Index j) const {
  const auto column = std::min(i, j), row = std::max(i, j);
  const auto* begin = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column];
  const auto* end = lower_.innerIndexPtr() + lower_.outerIndexPtr()[column + 1];
  const auto* place = std::lower_bound(begin, end, static_cast<int>(row));
  assert(place != end && *place == row);
  return static_cast<std::uint32_t>(place - lower_.innerIndexPtr());
}

void ViewSystem::assemble(const ViewWeights& weights) {
  assert(weights.position.size() == problem_.grid.size());
  std::fill_n(lower_.valuePtr(), lower_.nonZeros(), 0.0);
  rhs_ = Eigen::VectorXd::Zero(lower_.rows());
  // The diagonal is the first entry of each column of a lower triangle.
  for (Eigen::Index i = 0; i < samples_; ++i)
    lower_.valuePtr()[lower_.outerIndexPtr()[i]] =
        weights.position[problem_.pixels[static_cast<std::size_t>(i)]];
  add_slopes(weights);
  if (with_bias_) add_bias_prior(weights);
}

void ViewSystem::add_slopes(const ViewWeights& weights) {
  double* values = lower_.valuePtr();
  const std::uint32_t* next = slope_slots_.data();
  problem_.slopes.for_each([&](int axis, std::size_t i) {
    const Row row = row_of(axis, i);
    const double weight = weights.slope[static_cast<std::size_t>(axis)][i];
    const double step = problem_.slopes.axes[static_cast<std::size_t>(axis)].step[i];
    for (int a = 0; a < terms(); ++a) {
      const double weighted = weight * row.coefficient[a];
      rhs_[row.unknown[a]] -= weighted * step;
      for (int b = 0; b <= a; ++b) {
        // Two terms on one unknown (a == b, or both biases of one normal): both orders count.
        const bool same = a != b && row.unknown[a] == row.unknown[b];
        values[*next++] += (same ? 2.0 : 1.0) * weighted * row.coefficient[b];
      }
    }
  });
}

void ViewSystem::add_bias_prior(const ViewWeights& weights) {
  double* values = lower_.valuePtr();
  const auto diagonal = [&](Eigen::Index i) -> double& {
    return values[lower_.outerIndexPtr()[i]];
  };
  for (Eigen::Index i = samples_; i < 3 * samples_; ++i) diagonal(i) += weights.bias_size;
  const std::uint32_t* next = smooth_slots_.data();
  for (const auto& [a, b] : neighbours_) {
    const double step = weights.bias_step_between(problem_.pixels[a], problem_.pixels[b]);
    for (const int block : {1, 2}) {
      diagonal(block * samples_ + a) += step;
      diagonal(block * samples_ + b) += step;
      values[*next++] -= step;
    }
  }
}

}  // namespace relief::hybrid
