// Time and memory of refining one view by its size: the linear system of equation (H5) by multigrid
// and by the direct solver, and the whole of refine_view with and without standard deviations; then
// the same of a view of the built-in object with a million samples. Processor time of all threads;
// Linux only.
//   cmake --preset bench && cmake --build --preset bench &&
//   build/bench/bench/relief_refine_scaling [SIDE OF THE VIEW IN PIXELS ...]
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include "bench/programs/wavy_view.h"
#include "hybrid/model/view_problem.h"
#include "hybrid/solver/view_solver.h"
#include "relief/hybrid/refine_view.h"
#include "relief/simulation/simulate.h"
#include "scan/base/parallel.h"

namespace relief {
namespace {

constexpr int kThreads = 2;
constexpr int kLargestDirect = 1024;  // beyond, its memory is out of the question
constexpr double kBiasStep = 0.028;

double processor_seconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// A field of /proc/self/status [bytes].
double memory(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(field)) return 1024.0 * std::strtod(line.c_str() + field.size(), nullptr);
  return 0.0;
}

// Memory beyond what was in use when it was made.
class PeakMemory {
 public:
  PeakMemory() {
    release_freed_memory();
    std::ofstream("/proc/self/clear_refs") << "5";  // resets the high-water mark
    before_ = memory("VmRSS:");
  }
  double peak() const { return memory("VmHWM:") - before_; }

 private:
  double before_ = 0.0;
};

struct Timed {
  Eigen::VectorXd y;
  double setup = 0.0, solve = 0.0;  // processor time [s]
  double wall = 0.0;                // of both [s]
  int iterations = 0;
};

Timed solve(const hybrid::ViewProblem& problem, hybrid::Solver kind) {
  Timed timed;
  const double wall = wall_seconds(), start = processor_seconds();
  const auto solver = hybrid::make_view_solver(problem, true, kind);
  if (!solver->set_weights(wavy_weights(problem, kWavyNormalNoise, kBiasStep))) std::abort();
  const double ready = processor_seconds();
  timed.y = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(problem.size()));
  timed.iterations = solver->minimise(timed.y, hybrid::RefineOptions().tolerance, 100).iterations;
  timed.setup = ready - start;
  timed.solve = processor_seconds() - ready;
  timed.wall = wall_seconds() - wall;
  return timed;
}

void measure_solvers(const RangeView& view, double pixels) {
  const hybrid::ViewProblem problem =
      hybrid::make_view_problem(view, connect_samples(view), hybrid::Stencil::kCompactEdge);
  const Timed fast = solve(problem, hybrid::Solver::kMultigrid);
  std::printf(
      "%9.2f  multigrid   setup %6.2f us/pixel, %2d steps %6.2f us/pixel, %.3f s, %.3f s wall\n",
      pixels / 1048576.0, 1e6 * fast.setup / pixels, fast.iterations, 1e6 * fast.solve / pixels,
      fast.setup + fast.solve, fast.wall);
  if (view.width() > kLargestDirect) return;
  const Timed direct = solve(problem, hybrid::Solver::kCholesky);
  const double direct_time = direct.setup + direct.solve;
  std::printf("%9s  direct      %6.2f us/pixel, %.1f times longer; x differs by %.1e of its norm\n",
              "", 1e6 * direct_time / pixels, direct_time / (fast.setup + fast.solve),
              (direct.y - fast.y).head(direct.y.size() / 3).norm() /
                  direct.y.head(direct.y.size() / 3).norm());
}

void measure_refinement(const RangeView& view, bool deviation) {
  const auto pixels = static_cast<double>(view.range.size());
  hybrid::RefineOptions options;
  options.deviation = deviation;
  const PeakMemory memory_used;
  const double wall = wall_seconds(), start = processor_seconds();
  const auto refined = hybrid::refine_view(view, options);
  const double time = processor_seconds() - start, elapsed = wall_seconds() - wall;
  if (!refined) std::abort();
  std::printf(
      "%9s  refine_view %s deviations: %.2f us/pixel, %.2f s, %.2f s wall, %d rounds, %d steps, "
      "%.0f bytes/pixel\n",
      "", deviation ? "with   " : "without", 1e6 * time / pixels, time, elapsed, refined->rounds,
      refined->iterations, memory_used.peak() / pixels);
}

// A million samples of the built-in object.
RangeView object_view() {
  simulation::SimulationOptions options;
  options.views = 1;
  options.width = options.height = 1150;
  options.fill = 1.35;
  options.mesh_divisions = 0;
  auto simulation = simulation::simulate(options);
  if (!simulation) std::abort();
  return std::move(simulation->scans.views.front());
}

void measure(const std::vector<int>& sides) {
  std::printf("megapixels\n");
  for (const int side : sides) {
    const RangeView view = wavy_view(side);
    measure_solvers(view, static_cast<double>(side) * side);
    for (const bool deviation : {false, true}) measure_refinement(view, deviation);
    std::fflush(stdout);
  }
  const RangeView view = object_view();
  std::printf("built-in object, %zu samples\n", view.sample_count());
  for (const bool deviation : {false, true}) measure_refinement(view, deviation);
}

}  // namespace
}  // namespace relief

int main(int argc, char** argv) {
  std::vector<int> sides;
  for (int k = 1; k < argc; ++k) sides.push_back(std::atoi(argv[k]));
  if (sides.empty()) sides = {512, 1024, 2048, 4096};
  relief::on_threads(relief::kThreads, [&] { relief::measure(sides); });
}
