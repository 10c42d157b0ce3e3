// Conjugate gradient steps that the multigrid solver takes for equation (H5), by mask and by the
// two lengths [samples] that govern the system: sigma_p / (l sigma_n), up to which normals are
// trusted, and sigma_n / sigma_b, below which the bias is smooth. The table of docs/results.md.
//   cmake --preset bench && cmake --build --preset bench && build/bench/bench/relief_solver_steps
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "bench/programs/wavy_view.h"
#include "hybrid/model/view_problem.h"
#include "hybrid/solver/view_solver.h"
#include "relief/hybrid/refine_view.h"

namespace relief {
namespace {

constexpr int kSide = 240;

struct Lengths {
  double position, bias;
};
constexpr Lengths kLengths[] = {{1e-3, 1}, {0.1, 1},   {1, 1},    {10, 1},  {100, 1},
                                {1e3, 1},  {100, 100}, {1e3, 10}, {1e4, 1}, {1e5, 0.3}};

// Which samples there are, and the orders of magnitude by which weights of constraints differ.
struct Case {
  std::string name;
  RangeView view;
  double jumps = 0.0;
};

template <typename Keep>
RangeView masked(const Keep& keep) {
  RangeView view = wavy_view(kSide);
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      if (!keep(u, v)) view.range(u, v) = kNoSample;
  return view;
}

RangeView with_holes(double share) {
  std::mt19937 generator(7);
  return masked([&](int, int) { return static_cast<double>(generator()) >= share * 0x1p32; });
}

hybrid::ViewWeights weights_of(const hybrid::ViewProblem& problem, const Lengths& lengths,
                               double jumps) {
  const double sigma_normal = kWavyRangeNoise / lengths.position;
  hybrid::ViewWeights weights = wavy_weights(problem, sigma_normal, sigma_normal / lengths.bias);
  if (jumps == 0.0) return weights;
  std::mt19937 generator(11);
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const double uniform = static_cast<double>(generator()) * 0x1p-32;
    weights.slope[static_cast<std::size_t>(axis)][i] *=
        static_cast<float>(std::pow(10.0, -jumps * std::pow(uniform, 4)));
  });
  return weights;
}

int steps_for(const hybrid::ViewProblem& problem, const Lengths& lengths, double jumps) {
  const auto solver = hybrid::make_view_solver(problem, true, hybrid::Solver::kMultigrid);
  if (!solver->set_weights(weights_of(problem, lengths, jumps))) std::abort();
  Eigen::VectorXd y = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(problem.size()));
  return solver->minimise(y, hybrid::RefineOptions().tolerance, 500).iterations;
}

void print_row(const Case& of) {
  const hybrid::ViewProblem problem =
      hybrid::make_view_problem(of.view, connect_samples(of.view), hybrid::Stencil::kCompactEdge);
  std::printf("| %s |", of.name.c_str());
  for (const Lengths& lengths : kLengths)
    std::printf(" %d |", steps_for(problem, lengths, of.jumps));
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace
}  // namespace relief

int main() {
  using relief::kSide;
  std::printf("| mask, weights |");
  for (const auto& lengths : relief::kLengths)
    std::printf(" %g, %g |", lengths.position, lengths.bias);
  std::printf("\n");
  const auto all = [](int, int) { return true; };
  const auto islands = [](int u, int v) { return u % 3 != 2 && v % 3 != 2; };
  const auto lines = [](int, int v) { return v % 2 == 0; };
  const auto folded = [](int u, int v) { return v % 2 == 0 || u == (v % 4 == 1 ? kSide - 1 : 0); };
  relief::print_row({"full", relief::masked(all)});
  relief::print_row({"10 % of the samples missing at random", relief::with_holes(0.1)});
  relief::print_row({"30 % missing: near percolation", relief::with_holes(0.3)});
  relief::print_row({"6400 islands of 2 x 2", relief::masked(islands)});
  relief::print_row({"lines one sample wide", relief::masked(lines)});
  relief::print_row({"one line of 29 thousand samples, folded up", relief::masked(folded)});
  relief::print_row(
      {"full, weights of neighbouring constraints differ by up to 10^4", relief::masked(all), 4.0});
  relief::print_row(
      {"10 % missing and weights differ by up to 10^4", relief::with_holes(0.1), 4.0});
}
