#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkTrivialProducer.h>

#include "relief/fusion/merge_views.h"
#include "relief/hybrid/refine_view.h"
#include "relief/interop/vtk_conversion.h"
#include "relief/interop/vtk_merge_views.h"
#include "relief/interop/vtk_refine_view.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/small_meshes.h"

namespace relief::interop {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::largest_distance;

// What a VTK object reports, instead of its being printed.
class Reports : public vtkCommand {
 public:
  static Reports* New() { return new Reports; }
  void Execute(vtkObject*, unsigned long event, void* data) override {
    const char* text = static_cast<const char*>(data);
    if (event == vtkCommand::ErrorEvent) error += text;
    if (event == vtkCommand::WarningEvent) warning += text;
  }
  std::string error, warning;
};

// The errors of the filter; those of its executive, which repeat them, are dropped.
vtkSmartPointer<Reports> observe(vtkAlgorithm* filter) {
  auto reports = vtkSmartPointer<Reports>::New();
  filter->AddObserver(vtkCommand::ErrorEvent, reports);
  filter->AddObserver(vtkCommand::WarningEvent, reports);
  filter->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, vtkSmartPointer<Reports>::New());
  return reports;
}

// Eight noisy views of a bumpy object, without their confidences and colours.
const std::vector<RangeView>& views() {
  static const std::vector<RangeView> instance =
      testing::ring_of_views({.views = 8, .pixels = 64, .tilts = {-0.5, 0.5}});
  return instance;
}

vtkSmartPointer<vtkTrivialProducer> source(const RangeView& view) {
  auto producer = vtkSmartPointer<vtkTrivialProducer>::New();
  producer->SetOutput(to_image_data(view));
  return producer;
}

TEST(VtkFilters, RefiningGivesTheSameAsTheDirectCall) {
  vtkNew<vtkReliefRefineView> refine;
  const auto reports = observe(refine);
  refine->SetInputConnection(source(views()[0])->GetOutputPort());
  refine->SetSigmaNormal(0.02);
  refine->SetRobustRounds(2);
  refine->Update();
  EXPECT_EQ(refine->GetStatus(), "refined") << reports->error << reports->warning;
  const auto found = value_of(to_range_view(*refine->GetOutput()));
  hybrid::RefineOptions options;
  options.sigma_normal = 0.02;
  options.robust_rounds = 2;
  const auto direct = value_of(hybrid::refine_view(views()[0], options));
  EXPECT_EQ(refine->GetNumberOfRefinedSamples(), static_cast<vtkIdType>(direct.refined));
  EXPECT_EQ(refine->GetRmsChange(), direct.rms_change);
  ASSERT_EQ(found.sample_count(), direct.view.sample_count());
  EXPECT_EQ(found.deviation(32, 32), direct.view.deviation(32, 32));
  EXPECT_NEAR((found.point(32, 32) - direct.view.point(32, 32)).norm(), 0.0, 1e-10);
}

TEST(VtkFilters, APipelineGivesTheSameMeshAsTheDirectCalls) {
  vtkNew<vtkReliefMergeViews> merge;
  const auto reports = observe(merge);
  std::vector<RangeView> refined;
  for (const RangeView& view : views()) {
    vtkNew<vtkReliefRefineView> refine;
    refine->SetInputConnection(source(view)->GetOutputPort());
    merge->AddInputConnection(refine->GetOutputPort());
    refined.push_back(hybrid::refine_view(view)->view);
  }
  merge->Update();
  ASSERT_THAT(reports->error, IsEmpty());
  const auto direct = value_of(fusion::merge_views(refined));
  const auto found = value_of(to_triangle_mesh(*merge->GetOutput()));
  EXPECT_TRUE(merge->GetWatertight());
  EXPECT_NEAR(merge->GetUsedVoxelSize(), direct.voxel_size, 1e-9);
  EXPECT_NEAR(merge->GetFilledAreaFraction(), direct.filled_area_fraction, 1e-6);
  EXPECT_EQ(found.views, direct.mesh.views);
  EXPECT_EQ(found.faces, direct.mesh.faces);
  EXPECT_LT(largest_distance(found, direct.mesh), 1e-5 * direct.voxel_size);
}

TEST(VtkFilters, PropertiesReachTheMerging) {
  vtkNew<vtkReliefMergeViews> merge;
  for (const RangeView& view : views()) merge->AddInputDataObject(to_image_data(view));
  merge->SetVoxelSize(3.0);
  merge->KeepHolesOn();
  merge->Update();
  EXPECT_EQ(merge->GetUsedVoxelSize(), 3.0);
  EXPECT_FALSE(merge->GetWatertight());
  const vtkIdType open = merge->GetOutput()->GetNumberOfPoints();
  merge->KeepHolesOff();
  merge->Update();
  EXPECT_TRUE(merge->GetWatertight());
  EXPECT_GT(merge->GetOutput()->GetNumberOfPoints(), open);
}

TEST(VtkFilters, ErrorsNameWhatIsWrong) {
  vtkNew<vtkReliefRefineView> refine;
  auto reports = observe(refine);
  refine->SetInputData(vtkNew<vtkPolyData>());
  refine->Update();
  EXPECT_THAT(reports->error, HasSubstr("no field array 'grid_size'"));
  EXPECT_EQ(refine->GetOutput()->GetNumberOfPoints(), 0);

  vtkNew<vtkReliefMergeViews> merge;
  reports = observe(merge);
  merge->AddInputDataObject(to_image_data(views()[0]));
  const auto damaged = to_image_data(views()[1]);
  damaged->GetPointData()->RemoveArray("range");
  merge->AddInputDataObject(damaged);
  merge->Update();
  EXPECT_THAT(reports->error, HasSubstr("input 1: the image has no point array 'range'"));
}

TEST(VtkFilters, OptionsOutOfRangeAreErrors) {
  vtkNew<vtkReliefRefineView> refine;
  const auto reports = observe(refine);
  refine->SetInputConnection(source(views()[0])->GetOutputPort());
  refine->SetLambda(2.0);
  refine->Update();
  EXPECT_THAT(reports->error, HasSubstr("lambda"));
  EXPECT_EQ(refine->GetOutput()->GetNumberOfPoints(), 0);
}

TEST(VtkFilters, AViewWithoutNormalsComesOutAsMeasured) {
  RangeView view = views()[0];
  view.normals = {};
  vtkNew<vtkReliefRefineView> refine;
  const auto reports = observe(refine);
  refine->SetInputConnection(source(view)->GetOutputPort());
  refine->Update();
  EXPECT_THAT(reports->warning, HasSubstr(refine->GetStatus()));
  EXPECT_NE(refine->GetStatus(), "refined");
  EXPECT_EQ(refine->GetOutput()->GetNumberOfPoints(), static_cast<vtkIdType>(view.sample_count()));
}

// Sets AbortExecute when told of progress.
class Aborter : public vtkCommand {
 public:
  static Aborter* New() { return new Aborter; }
  void Execute(vtkObject* caller, unsigned long, void*) override {
    ++calls;
    static_cast<vtkAlgorithm*>(caller)->AbortExecuteOn();
  }
  int calls = 0;
};

TEST(VtkFilters, StopWhenAborted) {
  vtkNew<vtkReliefMergeViews> merge;
  for (const RangeView& view : views()) merge->AddInputDataObject(to_image_data(view));
  vtkNew<Aborter> aborter;
  merge->AddObserver(vtkCommand::ProgressEvent, aborter);
  const auto reports = observe(merge);
  merge->Update();
  EXPECT_GT(aborter->calls, 0);
  EXPECT_EQ(merge->GetOutput()->GetNumberOfPoints(), 0);
  EXPECT_THAT(reports->error, IsEmpty());
}

TEST(VtkFilters, PrintTheirProperties) {
  std::ostringstream text;
  vtkNew<vtkReliefRefineView>()->Print(text);
  vtkNew<vtkReliefMergeViews>()->Print(text);
  for (const char* name : {"vtkReliefRefineView", "SigmaNormal: 0", "RobustRounds: 5",
                           "vtkReliefMergeViews", "VoxelSize: 0", "KeepHoles: 0"})
    EXPECT_THAT(text.str(), HasSubstr(name));
}

}  // namespace
}  // namespace relief::interop
