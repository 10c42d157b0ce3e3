#include "relief/interop/vtk_refine_view.h"

#include <vtkDataSet.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>

#include "interop/vtk_filter_private.h"
#include "relief/hybrid/refine_view.h"
#include "relief/interop/vtk_conversion.h"

vtkStandardNewMacro(vtkReliefRefineView);

namespace {

relief::hybrid::RefineOptions options_of(vtkReliefRefineView& filter) {
  relief::hybrid::RefineOptions options;
  if (filter.GetSigmaPosition() != 0.0) options.sigma_position = filter.GetSigmaPosition();
  if (filter.GetSigmaNormal() != 0.0) options.sigma_normal = filter.GetSigmaNormal();
  if (filter.GetLambda() != 0.0) options.lambda = filter.GetLambda();
  options.bias = static_cast<relief::hybrid::BiasModel>(filter.GetBiasModel());
  options.robust_rounds = filter.GetRobustRounds();
  return options;
}

}  // namespace

int vtkReliefRefineView::FillInputPortInformation(int, vtkInformation* info) {
  relief::interop::accept_range_views(*info);
  return 1;
}

int vtkReliefRefineView::RequestData(vtkInformation*, vtkInformationVector** inputs,
                                     vtkInformationVector* outputs) {
  this->Status.clear();
  this->NumberOfRefinedSamples = 0;
  this->RmsChange = 0.0;
  vtkDataSet* input = vtkDataSet::GetData(inputs[0]);
  const auto view = relief::interop::to_range_view(*input);
  if (!view) {
    vtkErrorMacro(<< view.error().message);
    return 0;
  }
  const auto refined =
      relief::hybrid::refine_view(*view, options_of(*this), relief::interop::context_of(*this));
  if (!refined) {
    if (refined.error().kind == relief::ErrorKind::kInterrupted) return 1;
    vtkErrorMacro(<< refined.error().message);
    return 0;
  }
  this->Status = to_string(refined->status);
  this->NumberOfRefinedSamples = static_cast<vtkIdType>(refined->refined);
  this->RmsChange = refined->rms_change;
  if (refined->status != relief::hybrid::RefineStatus::kRefined) vtkWarningMacro(<< this->Status);
  vtkPolyData::GetData(outputs)->ShallowCopy(relief::interop::to_poly_data(refined->view));
  return 1;
}

void vtkReliefRefineView::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SigmaPosition: " << this->SigmaPosition << "\n";
  os << indent << "SigmaNormal: " << this->SigmaNormal << "\n";
  os << indent << "Lambda: " << this->Lambda << "\n";
  os << indent << "BiasModel: " << this->BiasModel << "\n";
  os << indent << "RobustRounds: " << this->RobustRounds << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Status: " << this->Status << "\n";
  os << indent << "NumberOfRefinedSamples: " << this->NumberOfRefinedSamples << "\n";
  os << indent << "RmsChange: " << this->RmsChange << "\n";
}
