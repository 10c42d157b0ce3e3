// Refines and merges scans in a VTK pipeline.
#include <cstdio>

#include <relief/interop/vtk_conversion.h>
#include <relief/interop/vtk_merge_views.h>
#include <relief/interop/vtk_refine_view.h>
#include <vtkNew.h>

#include "relief/simulation/simulate.h"

int main() {
  relief::simulation::SimulationOptions options;
  options.views = 6;
  options.width = options.height = 96;
  options.mesh_divisions = 0;
  const auto simulation = relief::simulation::simulate(options);
  if (!simulation) return 1;

  vtkNew<vtkReliefMergeViews> merge;
  for (std::size_t i = 0; i < simulation->scans.views.size(); ++i) {
    relief::RangeView view = simulation->scans.views[i];
    view.world_from_view = simulation->truth.views[i].world_from_view;
    vtkNew<vtkReliefRefineView> refine;
    refine->SetInputData(relief::interop::to_image_data(view));
    merge->AddInputConnection(refine->GetOutputPort());
  }
  merge->Update();
  std::printf("vtk_consumer: a %s model of %lld faces\n",
              merge->GetWatertight() ? "watertight" : "damaged",
              static_cast<long long>(merge->GetOutput()->GetNumberOfPolys()));
  return merge->GetWatertight() ? 0 : 1;
}
