// Simulates a few scans and reconstructs the model through the installed headers only.
#include <cstdio>

#include <relief/reconstruction/reconstruct.h>
#include <relief/simulation/simulate.h>

int main() {
  relief::simulation::SimulationOptions options;
  options.views = 6;
  options.width = options.height = 96;
  options.mesh_divisions = 0;
  const auto simulation = relief::simulation::simulate(options);
  if (!simulation) return 1;

  const auto result = relief::reconstruction::reconstruct(simulation->scans.views);
  if (!result) {
    std::fprintf(stderr, "consumer: %s\n", result.error().message.c_str());
    return 1;
  }
  if (!result->model.check.watertight()) return 1;
  std::printf("consumer: a watertight model of %zu faces\n", result->model.check.faces);
  return 0;
}
