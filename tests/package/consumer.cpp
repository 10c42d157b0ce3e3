// Simulates a few scans, aligns, refines and merges them through the installed headers only.
#include <cstdio>
#include <vector>

#include "fusion/merge_views.h"
#include "hybrid/refine_view.h"
#include "registration/align_views.h"
#include "scan/simulation/simulate.h"

int main() {
  relief::SimulationOptions options;
  options.views = 6;
  options.width = options.height = 96;
  options.mesh_divisions = 0;
  const auto simulation = relief::simulate(options);
  if (!simulation) return 1;

  std::vector<relief::RangeView> views = simulation->scans.views;
  const auto alignment = relief::align_views(views);
  if (!alignment) return 1;
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].world_from_view = alignment->views[i].world_from_view;
    const auto refined = relief::refine_view(views[i]);
    if (!refined) return 1;
    views[i] = refined->view;
  }
  const auto model = relief::merge_views(views);
  if (!model || !model->check.watertight()) return 1;
  std::printf("consumer: a watertight model of %zu faces\n", model->check.faces);
  return 0;
}
