#include "hybrid/view_problem.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace relief {

namespace {

constexpr std::uint32_t kPinned = std::numeric_limits<std::uint32_t>::max();

// Disjoint sets of pixels; the representative of a set is its smallest member.
class Components {
 public:
  explicit Components(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

// Positive confidences are kept within six orders of magnitude of the largest: beyond that they
// only cost precision.
float usable_confidence(float confidence, float largest) {
  return confidence > 0.0f ? std::max(confidence, 1e-6f * largest) : 0.0f;
}

// 1 for every pixel whose component of constraints has some confidence to hold it.
std::vector<std::uint8_t> movable_pixels(const RangeView& view,
                                         const std::vector<SlopeConstraint>& slopes) {
  Components components(view.range.size());
  for (const auto& c : slopes) {
    components.join(c.tail, c.head);
    components.join(c.head, c.at[0]);
    components.join(c.head, c.at[1]);
  }
  std::vector<std::uint8_t> held(view.range.size(), 0), movable(view.range.size(), 0);
  const auto confident = [&](std::uint32_t i) {
    return view.confidence.empty() || view.confidence[i] > 0.0f;
  };
  for (const auto& c : slopes)
    for (const std::uint32_t i : {c.tail, c.head})
      if (confident(i)) held[components.find(i)] = 1;
  for (const auto& c : slopes)
    for (const std::uint32_t i : {c.tail, c.head, c.at[0], c.at[1]})
      movable[i] = held[components.find(i)];
  return movable;
}

void number_samples(const RangeView& view, const std::vector<std::uint8_t>& movable,
                    ViewProblem& problem, std::vector<std::uint32_t>& number) {
  for (std::size_t i = 0; i < movable.size(); ++i) {
    if (!movable[i]) continue;
    number[i] = static_cast<std::uint32_t>(problem.pixels.size());
    problem.pixels.push_back(static_cast<std::uint32_t>(i));
  }
  float largest = 0.0f;
  for (const float c : view.confidence) largest = std::max(largest, c);
  problem.confidence = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(problem.size()));
  if (view.confidence.empty()) return;
  for (std::size_t k = 0; k < problem.size(); ++k)
    problem.confidence[static_cast<Eigen::Index>(k)] =
        usable_confidence(view.confidence[problem.pixels[k]], largest);
}

// With the compact stencil the neighbours are those that share a constraint; the central one's
// constraints skip a sample.
void add_neighbours(const RangeView& view, const GridEdges& edges,
                    const std::vector<std::uint32_t>& number, ViewProblem& problem) {
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      for (const auto& [du, dv] : {std::pair{1, 0}, {0, 1}}) {
        if (!edges.connected(u, v, du, dv)) continue;
        if (!view.has_normal(u, v) || !view.has_normal(u + du, v + dv)) continue;
        const std::uint32_t a = number[view.range.index(u, v)];
        const std::uint32_t b = number[view.range.index(u + du, v + dv)];
        if (a != kPinned && b != kPinned) problem.neighbours.push_back({a, b});
      }
    }
  }
}

}  // namespace

ViewProblem make_view_problem(const RangeView& view, const GridEdges& edges, Stencil stencil) {
  ViewProblem problem;
  problem.stencil = stencil;
  problem.width = view.width();
  problem.height = view.height();
  std::vector<SlopeConstraint> slopes = slope_constraints(view, edges, stencil);
  const std::vector<std::uint8_t> movable = movable_pixels(view, slopes);
  std::vector<std::uint32_t> number(view.range.size(), kPinned);
  number_samples(view, movable, problem, number);
  for (SlopeConstraint& c : slopes) {
    if (!movable[c.tail]) continue;
    c.tail = number[c.tail];
    c.head = number[c.head];
    c.at = {number[c.at[0]], number[c.at[1]]};
    problem.slopes.push_back(c);
  }
  if (stencil == Stencil::kCompactEdge)
    for (const SlopeConstraint& c : problem.slopes) problem.neighbours.push_back(c.at);
  else
    add_neighbours(view, edges, number, problem);
  problem.pinned = view.sample_count() - problem.size();
  return problem;
}

Eigen::VectorXd slope_residuals(const ViewProblem& problem, const Eigen::VectorXd& y) {
  const auto count = static_cast<Eigen::Index>(problem.size());
  const bool with_bias = y.size() > count;
  Eigen::VectorXd residuals(static_cast<Eigen::Index>(problem.slopes.size()));
  for (std::size_t k = 0; k < problem.slopes.size(); ++k) {
    const SlopeConstraint& c = problem.slopes[k];
    double residual =
        double{c.step} + double{c.head_slope} * y[c.head] - double{c.tail_slope} * y[c.tail];
    const Eigen::Index bias = (1 + c.axis) * count;
    if (with_bias) residual -= 0.5 * double{c.length} * (y[bias + c.at[0]] + y[bias + c.at[1]]);
    residuals[static_cast<Eigen::Index>(k)] = residual;
  }
  return residuals;
}

}  // namespace relief
