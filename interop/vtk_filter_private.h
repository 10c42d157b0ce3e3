#pragma once

#include <string>

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkInformation.h>

#include "relief/scan/context.h"

namespace relief::interop {

/// Lets an input port take range views in either form of vtk_conversion.h.
inline void accept_range_views(vtkInformation& port) {
  port.Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  port.Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
}

/// The threads of a filter, and a progress that tells its observers and stops when one has set
/// AbortExecute.
template <typename Filter>
Context context_of(Filter& filter) {
  Context context;
  context.threads = filter.GetNumberOfThreads();
  context.progress = [&filter](double fraction, std::string_view step) {
    filter.SetProgressText(std::string(step).c_str());
    filter.UpdateProgress(fraction);
    return filter.GetAbortExecute() == 0;
  };
  return context;
}

}  // namespace relief::interop
