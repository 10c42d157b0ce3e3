#pragma once

#include <vtkPolyDataAlgorithm.h>

/// Merging as a VTK filter: range views with poses to one closed surface
/// (relief::fusion::merge_views).
///
/// Input: one view for each connection (AddInputConnection, AddInputData), as vtkImageData or
/// vtkPolyData (relief/interop/vtk_conversion.h). Output: the closed model in the world frame with
/// its point arrays (`quality`, `views`, `filled`, normals, `RGB`). What the user should know is
/// reported as warnings. Data that are no views, and views that give no surface, are errors and
/// give an empty output. While AbortExecute is set the filter stops at the next report of its
/// progress, with an empty output.
class vtkReliefMergeViews : public vtkPolyDataAlgorithm {
 public:
  static vtkReliefMergeViews* New();
  vtkTypeMacro(vtkReliefMergeViews, vtkPolyDataAlgorithm)
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// Spacing of the lattice the surface is extracted from [unit]; 0 (default): that of the samples.
  vtkSetMacro(VoxelSize, double);
  vtkGetMacro(VoxelSize, double);
  /// How far from their surface views contribute [unit]; 0 (default): by the noise of the views.
  vtkSetMacro(Truncation, double);
  vtkGetMacro(Truncation, double);
  /// Leave the surface open where no view measured it; off by default.
  vtkSetMacro(KeepHoles, bool);
  vtkGetMacro(KeepHoles, bool);
  vtkBooleanMacro(KeepHoles, bool);
  /// Leave open the holes that reach farther than this from what was measured [unit]; 0 (default):
  /// none.
  vtkSetMacro(LargestFill, double);
  vtkGetMacro(LargestFill, double);
  /// Keep surfaces apart from the largest one; off by default.
  vtkSetMacro(KeepComponents, bool);
  vtkGetMacro(KeepComponents, bool);
  vtkBooleanMacro(KeepComponents, bool);
  /// Take all samples of views that others contradict; off by default.
  vtkSetMacro(KeepContradicted, bool);
  vtkGetMacro(KeepContradicted, bool);
  vtkBooleanMacro(KeepContradicted, bool);
  /// Keep also the small handles that no view measured; off by default.
  vtkSetMacro(KeepHandles, bool);
  vtkGetMacro(KeepHandles, bool);
  vtkBooleanMacro(KeepHandles, bool);
  /// 0 (default): one per core. The result does not depend on it.
  vtkSetMacro(NumberOfThreads, int);
  vtkGetMacro(NumberOfThreads, int);

  /// Of the last execution: whether the model is closed, manifold and oriented.
  vtkGetMacro(Watertight, bool);
  /// How much of its area no view measured.
  vtkGetMacro(FilledAreaFraction, double);
  /// The spacing of the lattice as used [unit].
  vtkGetMacro(UsedVoxelSize, double);

 protected:
  vtkReliefMergeViews() = default;
  ~vtkReliefMergeViews() override = default;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputs,
                  vtkInformationVector* outputs) override;

 private:
  vtkReliefMergeViews(const vtkReliefMergeViews&) = delete;
  void operator=(const vtkReliefMergeViews&) = delete;

  double VoxelSize = 0.0;
  double Truncation = 0.0;
  double LargestFill = 0.0;
  bool KeepHoles = false;
  bool KeepComponents = false;
  bool KeepContradicted = false;
  bool KeepHandles = false;
  int NumberOfThreads = 0;
  bool Watertight = false;
  double FilledAreaFraction = 0.0;
  double UsedVoxelSize = 0.0;
};
