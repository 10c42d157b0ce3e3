// Time of each stage on simulated scans of the built-in object, by number of threads.
//   cmake --preset bench && cmake --build --preset bench &&
//   build/bench/bench/relief_stages_benchmark
#include <cstdlib>
#include <map>

#include <benchmark/benchmark.h>

#include "relief/fusion/merge_views.h"
#include "relief/hybrid/refine_view.h"
#include "relief/registration/align_views.h"
#include "relief/simulation/simulate.h"

namespace relief {
namespace {

const simulation::Simulation& scans(int size) {
  static std::map<int, simulation::Simulation> simulations;
  if (const auto found = simulations.find(size); found != simulations.end()) return found->second;
  simulation::SimulationOptions options;
  options.width = options.height = size;
  options.mesh_divisions = 0;
  auto simulation = simulation::simulate(options);
  if (!simulation) std::abort();
  return simulations.emplace(size, std::move(simulation).value()).first->second;
}

void count_samples(benchmark::State& state, const std::vector<RangeView>& views) {
  std::size_t samples = 0;
  for (const RangeView& view : views) samples += view.sample_count();
  state.counters["samples"] = static_cast<double>(samples);
  state.counters["samples/s"] = benchmark::Counter(static_cast<double>(samples),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

void align(benchmark::State& state) {
  const auto& views = scans(static_cast<int>(state.range(0))).scans.views;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        registration::align_views(views, {}, {.threads = static_cast<int>(state.range(1))}));
  count_samples(state, views);
}

void refine(benchmark::State& state) {
  const RangeView& view = scans(static_cast<int>(state.range(0))).scans.views.front();
  const Context context{.threads = static_cast<int>(state.range(1))};
  for (auto _ : state) benchmark::DoNotOptimize(hybrid::refine_view(view, {}, context));
  count_samples(state, {view});
}

void merge(benchmark::State& state) {
  const auto& views = scans(static_cast<int>(state.range(0))).truth.views;
  const Context context{.threads = static_cast<int>(state.range(1))};
  for (auto _ : state) benchmark::DoNotOptimize(fusion::merge_views(views, {}, context));
  count_samples(state, views);
}

void sizes_and_threads(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"size", "threads"})
      ->ArgsProduct({{256, 512}, {1, 2}})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

BENCHMARK(align)->Apply(sizes_and_threads);
BENCHMARK(refine)->Apply(sizes_and_threads);
BENCHMARK(merge)->Apply(sizes_and_threads);

}  // namespace
}  // namespace relief

BENCHMARK_MAIN();
