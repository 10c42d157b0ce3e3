#include "relief/interop/vtk_merge_views.h"

#include <string>
#include <utility>
#include <vector>

#include <vtkDataSet.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>

#include "interop/vtk_filter_private.h"
#include "relief/fusion/merge_views.h"
#include "relief/interop/vtk_conversion.h"

vtkStandardNewMacro(vtkReliefMergeViews);

namespace {

relief::fusion::MergeOptions options_of(vtkReliefMergeViews& filter) {
  relief::fusion::MergeOptions options;
  options.voxel_size = filter.GetVoxelSize();
  options.truncation = filter.GetTruncation();
  options.keep_holes = filter.GetKeepHoles();
  options.largest_fill = filter.GetLargestFill();
  options.keep_components = filter.GetKeepComponents();
  options.keep_contradicted = filter.GetKeepContradicted();
  options.keep_handles = filter.GetKeepHandles();
  return options;
}

relief::Result<std::vector<relief::RangeView>> views_of(vtkInformationVector& connections) {
  std::vector<relief::RangeView> views;
  for (int i = 0; i < connections.GetNumberOfInformationObjects(); ++i) {
    auto view = relief::interop::to_range_view(*vtkDataSet::GetData(&connections, i));
    if (!view)
      return relief::Error{view.error().kind,
                           "input " + std::to_string(i) + ": " + view.error().message};
    views.push_back(std::move(*view));
  }
  return views;
}

}  // namespace

int vtkReliefMergeViews::FillInputPortInformation(int, vtkInformation* info) {
  relief::interop::accept_range_views(*info);
  info->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  return 1;
}

int vtkReliefMergeViews::RequestData(vtkInformation*, vtkInformationVector** inputs,
                                     vtkInformationVector* outputs) {
  this->Watertight = false;
  this->FilledAreaFraction = this->UsedVoxelSize = 0.0;
  const auto views = views_of(*inputs[0]);
  if (!views) {
    vtkErrorMacro(<< views.error().message);
    return 0;
  }
  const auto merged =
      relief::fusion::merge_views(*views, options_of(*this), relief::interop::context_of(*this));
  if (!merged) {
    if (merged.error().kind == relief::ErrorKind::kInterrupted) return 1;
    vtkErrorMacro(<< merged.error().message);
    return 0;
  }
  for (const std::string& note : merged->notes) vtkWarningMacro(<< note);
  this->Watertight = merged->check.watertight();
  this->FilledAreaFraction = merged->filled_area_fraction;
  this->UsedVoxelSize = merged->voxel_size;
  vtkPolyData::GetData(outputs)->ShallowCopy(relief::interop::to_poly_data(merged->mesh));
  return 1;
}

void vtkReliefMergeViews::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VoxelSize: " << this->VoxelSize << "\n";
  os << indent << "Truncation: " << this->Truncation << "\n";
  os << indent << "KeepHoles: " << this->KeepHoles << "\n";
  os << indent << "LargestFill: " << this->LargestFill << "\n";
  os << indent << "KeepComponents: " << this->KeepComponents << "\n";
  os << indent << "KeepContradicted: " << this->KeepContradicted << "\n";
  os << indent << "KeepHandles: " << this->KeepHandles << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Watertight: " << this->Watertight << "\n";
  os << indent << "FilledAreaFraction: " << this->FilledAreaFraction << "\n";
  os << indent << "UsedVoxelSize: " << this->UsedVoxelSize << "\n";
}
