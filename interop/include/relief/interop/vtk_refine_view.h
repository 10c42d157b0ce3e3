#pragma once

#include <string>

#include <vtkPolyDataAlgorithm.h>

/// Hybrid refinement as a VTK filter: moves the samples of a range view along their rays until its
/// surface agrees with its measured normals (relief::hybrid::refine_view).
///
/// Input: one view, as vtkImageData or vtkPolyData (relief/interop/vtk_conversion.h). Output: the
/// refined view as a surface in the world frame, with deviations. A view that cannot be refined
/// comes out as measured, one whose solver gave up as far as it came; GetStatus() then says why,
/// and a warning is reported. Data that are no view, and options out of range, are errors and give
/// an empty output. While AbortExecute is set the filter stops at the next report of its progress,
/// with an empty output.
class vtkReliefRefineView : public vtkPolyDataAlgorithm {
 public:
  /// What is done about the smooth error of normals, as relief::hybrid::BiasModel.
  enum BiasModels { LATENT, TWO_STEP, NONE };

  static vtkReliefRefineView* New();
  vtkTypeMacro(vtkReliefRefineView, vtkPolyDataAlgorithm)
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Standard deviation of the measured ranges [unit]; 0 (default): known to the view or estimated.
  vtkSetMacro(SigmaPosition, double);
  vtkGetMacro(SigmaPosition, double);
  /// Standard deviation of the measured normals [rad]; 0 (default): estimated.
  vtkSetMacro(SigmaNormal, double);
  vtkGetMacro(SigmaNormal, double);
  /// Weight of positions against normals, in (0, 1), in place of SigmaNormal; 0 (default): none.
  vtkSetMacro(Lambda, double);
  vtkGetMacro(Lambda, double);
  vtkSetClampMacro(BiasModel, int, LATENT, NONE);
  vtkGetMacro(BiasModel, int);
  /// Rounds of reweighting against outliers; 5 is the default.
  vtkSetMacro(RobustRounds, int);
  vtkGetMacro(RobustRounds, int);
  /// 0 (default): one per core. The result does not depend on it.
  vtkSetMacro(NumberOfThreads, int);
  vtkGetMacro(NumberOfThreads, int);

  /// Of the last execution: `refined`, or why the view is as measured. Empty before.
  std::string GetStatus() const { return this->Status; }
  /// Samples that normals constrained.
  vtkGetMacro(NumberOfRefinedSamples, vtkIdType);
  /// Root mean square of the motions of these samples along their rays [unit].
  vtkGetMacro(RmsChange, double);

 protected:
  vtkReliefRefineView() = default;
  ~vtkReliefRefineView() override = default;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputs,
                  vtkInformationVector* outputs) override;

 private:
  vtkReliefRefineView(const vtkReliefRefineView&) = delete;
  void operator=(const vtkReliefRefineView&) = delete;

  double SigmaPosition = 0.0;
  double SigmaNormal = 0.0;
  double Lambda = 0.0;
  int BiasModel = LATENT;
  int RobustRounds = 5;
  int NumberOfThreads = 0;
  std::string Status;
  vtkIdType NumberOfRefinedSamples = 0;
  double RmsChange = 0.0;
};
