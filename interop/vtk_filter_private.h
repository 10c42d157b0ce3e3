#pragma once

#include <string>

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkInformation.h>

#include "relief/scan/progress.h"

namespace relief::interop {

/// Lets an input port take range views in either form of vtk_conversion.h.
inline void accept_range_views(vtkInformation& port) {
  port.Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  port.Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
}

/// Reports to the observers of a filter, and stops when one has set AbortExecute.
inline Progress progress_of(vtkAlgorithm& filter) {
  return [&filter](double fraction, std::string_view step) {
    filter.SetProgressText(std::string(step).c_str());
    filter.UpdateProgress(fraction);
    return filter.GetAbortExecute() == 0;
  };
}

}  // namespace relief::interop
