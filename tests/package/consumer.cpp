// Simulates a few scans, aligns, refines and merges them through the installed headers only.
#include <cstdio>
#include <utility>
#include <vector>

#include "relief/fusion/merge_views.h"
#include "relief/hybrid/refine_view.h"
#include "relief/registration/align_views.h"
#include "relief/registration/align_views.h"
#include "relief/simulation/simulate.h"

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
  relief::apply_alignment(*alignment, views);
  for (relief::RangeView& view : views) {
    auto refined = relief::refine_view(view);
    if (!refined) return 1;
    view = std::move(refined->view);
  }
  const auto model = relief::merge_views(views);
  if (!model || !model->check.watertight()) return 1;
  std::printf("consumer: a watertight model of %zu faces\n", model->check.faces);
  return 0;
}
