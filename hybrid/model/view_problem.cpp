#include "hybrid/model/view_problem.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "scan/base/disjoint_sets.h"
#include "scan/base/median_deviation.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::uint32_t kPinned = std::numeric_limits<std::uint32_t>::max();

// Positive confidences are kept within six orders of magnitude of the largest: beyond that they
// only cost precision.
float usable_confidence(float confidence, float largest) {
  return confidence > 0.0f ? std::max(confidence, 1e-6f * largest) : 0.0f;
}

// 1 for every pixel (padded) that some constraint moves or takes a normal from.
std::vector<std::uint8_t> constrained_pixels(const SlopeConstraints& slopes) {
  std::vector<std::uint8_t> constrained(slopes.grid.size(), 0);
  slopes.parallel_for_each([&](int axis, std::size_t i) {
    const auto ends = slopes.ends(axis, i);
    for (const std::size_t end : {ends.tail, ends.head, ends.at0, ends.at1}) constrained[end] = 1;
  });
  return constrained;
}

// 1 for every pixel (padded) whose component of constraints has some confidence to hold it.
std::vector<std::uint8_t> held_pixels(const RangeView& view, const SlopeConstraints& slopes) {
  const PaddedGrid& grid = slopes.grid;
  DisjointSets components(grid.size());
  slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = slopes.ends(axis, i);
    const auto join = [&](std::size_t a, std::size_t b) {
      components.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    };
    join(ends.tail, ends.head);
    if (ends.at0 == ends.at1) join(ends.head, ends.at0);
  });
  const PositionConfidence confidence(view);
  const auto confident = [&](std::size_t i) { return confidence(grid.u(i), grid.v(i)) > 0.0f; };
  std::vector<std::uint8_t> held(grid.size(), 0), movable(grid.size(), 0);
  slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = slopes.ends(axis, i);
    for (const std::size_t end : {ends.tail, ends.head})
      if (confident(end)) held[components.find(static_cast<std::uint32_t>(end))] = 1;
  });
  slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = slopes.ends(axis, i);
    for (const std::size_t end : {ends.tail, ends.head, ends.at0, ends.at1})
      movable[end] = held[components.find(static_cast<std::uint32_t>(end))];
  });
  return movable;
}

bool confident_everywhere(const RangeView& view) {
  if (view.confidence.empty() && view.deviation.empty()) return true;
  const PositionConfidence confidence(view);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v) && !(confidence(u, v) > 0.0f)) return false;
  return true;
}

// Samples without confidence hold nothing, neither themselves nor others.
std::vector<std::uint8_t> movable_pixels(const RangeView& view, const SlopeConstraints& slopes) {
  return confident_everywhere(view) ? constrained_pixels(slopes) : held_pixels(view, slopes);
}

void erase_unmovable(const std::vector<std::uint8_t>& movable, SlopeConstraints& slopes) {
  slopes.parallel_for_each([&](int axis, std::size_t i) {
    if (!movable[slopes.ends(axis, i).tail]) slopes.erase(axis, i);
  });
}

void number_samples(const RangeView& view, const std::vector<std::uint8_t>& movable,
                    ViewProblem& problem) {
  problem.pixels.reserve(
      static_cast<std::size_t>(std::count(movable.begin(), movable.end(), std::uint8_t{1})));
  for (std::size_t i = 0; i < movable.size(); ++i)
    if (movable[i]) problem.pixels.push_back(static_cast<std::uint32_t>(i));
  problem.confidence = Eigen::VectorXf::Ones(static_cast<Eigen::Index>(problem.size()));
  if (view.confidence.empty() && view.deviation.empty()) return;
  const PositionConfidence confidence(view);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const std::uint32_t i = problem.pixels[k];
    problem.confidence[static_cast<Eigen::Index>(k)] =
        confidence(problem.grid.u(i), problem.grid.v(i));
  }
  const float largest = problem.size() > 0 ? problem.confidence.maxCoeff() : 0.0f;
  for (float& value : problem.confidence) value = usable_confidence(value, largest);
}

// The constraints of the central stencil skip a sample: its neighbours follow from the edges.
void add_central_neighbours(const RangeView& view, const GridEdges& edges, ViewProblem& problem) {
  const std::vector<std::uint32_t> number = numbers_of(problem);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      for (const auto& [du, dv] : {std::pair{1, 0}, {0, 1}}) {
        if (!edges.connected(u, v, du, dv)) continue;
        if (!view.has_normal(u, v) || !view.has_normal(u + du, v + dv)) continue;
        const std::uint32_t a = number[problem.grid.index(u, v)];
        const std::uint32_t b = number[problem.grid.index(u + du, v + dv)];
        if (a != kPinned && b != kPinned) problem.central_neighbours.push_back({a, b});
      }
    }
  }
}

}  // namespace

PositionConfidence::PositionConfidence(const RangeView& view)
    : view_(view), nominal_(median_deviation(view)) {}

float PositionConfidence::operator()(int u, int v) const {
  const float deviation = view_.deviation_at(u, v);
  if (!(nominal_ > 0.0f && deviation > 0.0f)) return view_.confidence_at(u, v);
  const float ratio = nominal_ / deviation;
  return ratio * ratio;
}

ViewProblem make_view_problem(const RangeView& view, const GridEdges& edges, Stencil stencil) {
  ViewProblem problem;
  problem.grid = {view.width(), view.height()};
  problem.slopes = slope_constraints(view, edges, stencil);
  const std::vector<std::uint8_t> movable = movable_pixels(view, problem.slopes);
  number_samples(view, movable, problem);
  erase_unmovable(movable, problem.slopes);
  problem.constraints = problem.slopes.count();
  if (stencil == Stencil::kPaperCentral) add_central_neighbours(view, edges, problem);
  problem.pinned = view.sample_count() - problem.size();
  return problem;
}

std::vector<std::uint32_t> numbers_of(const ViewProblem& problem) {
  std::vector<std::uint32_t> number(problem.grid.size(), kPinned);
  for (std::size_t k = 0; k < problem.size(); ++k)
    number[problem.pixels[k]] = static_cast<std::uint32_t>(k);
  return number;
}

std::vector<std::array<std::uint32_t, 2>> bias_neighbours(const ViewProblem& problem) {
  if (problem.slopes.stencil == Stencil::kPaperCentral) return problem.central_neighbours;
  const std::vector<std::uint32_t> number = numbers_of(problem);
  std::vector<std::array<std::uint32_t, 2>> neighbours;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = problem.slopes.ends(axis, i);
    neighbours.push_back({number[ends.at0], number[ends.at1]});
  });
  return neighbours;
}

std::array<std::vector<float>, 2> slope_residuals(const ViewProblem& problem,
                                                  const Eigen::VectorXd& y) {
  constexpr std::size_t kRowsAtOnce = 32;  // Of one piece of work; changes no result.
  const PaddedGrid& grid = problem.grid;
  const auto count = static_cast<Eigen::Index>(problem.size());
  const bool with_bias = y.size() > count;
  std::array<std::vector<float>, 2> residuals;
  std::vector<double> x(grid.size(), 0.0), bias(grid.size(), 0.0);
  const auto spread = [&](Eigen::Index block, std::vector<double>& plane) {
    for (Eigen::Index k = 0; k < count; ++k)
      plane[problem.pixels[static_cast<std::size_t>(k)]] = y[block * count + k];
  };
  spread(0, x);
  for (const int axis : {0, 1}) {
    if (with_bias) spread(1 + axis, bias);
    const SlopeConstraints::Axis& a = problem.slopes.axes[static_cast<std::size_t>(axis)];
    std::vector<float>& out = residuals[static_cast<std::size_t>(axis)];
    out.assign(grid.size(), 0.0f);
    parallel_for(static_cast<std::size_t>(grid.height), kRowsAtOnce,
                 [&](std::size_t begin, std::size_t end) {
                   const std::size_t last = grid.index(0, static_cast<int>(end));
                   for (std::size_t i = grid.index(0, static_cast<int>(begin)); i < last; ++i) {
                     if (!problem.slopes.exists(axis, i)) continue;
                     const auto ends = problem.slopes.ends(axis, i);
                     out[i] =
                         static_cast<float>(double{a.step[i]} + a.head_slope[i] * x[ends.head] -
                                            a.tail_slope[i] * x[ends.tail] -
                                            a.half_length[i] * (bias[ends.at0] + bias[ends.at1]));
                   }
                 });
  }
  return residuals;
}

}  // namespace relief::hybrid
