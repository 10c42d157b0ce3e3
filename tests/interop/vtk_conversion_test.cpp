#include "relief/interop/vtk_conversion.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>

#include "relief/io/mesh_io.h"
#include "tests/interop/coloured_view.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief::interop {
namespace {

using testing::cameras_of_all_models;
using testing::coloured_view;
using testing::expect_same_mesh;
using testing::expect_same_samples;
using testing::mesh_with_attributes;

RangeView pinhole_view() { return coloured_view(cameras_of_all_models()[0]); }

void expect_same_attributes(const RangeView& found, const RangeView& given) {
  EXPECT_EQ(found.name, given.name);
  EXPECT_EQ(found.samples, given.samples);
  EXPECT_EQ(found.camera.can_project(), given.camera.can_project());
  for (int v = 0; v < given.height(); ++v) {
    for (int u = 0; u < given.width(); ++u) {
      if (!given.has_sample(u, v)) continue;
      ASSERT_EQ(found.confidence(u, v), given.confidence(u, v));
      ASSERT_EQ(found.deviation(u, v), given.deviation(u, v));
      ASSERT_EQ(found.colours(u, v), given.colours(u, v));
    }
  }
}

class VtkConversionOfViews : public ::testing::TestWithParam<Camera> {
 protected:
  void expect_view_back(vtkDataSet& data, double tolerance) const {
    const auto found = value_of(to_range_view(data));
    EXPECT_EQ(found.camera.model(), GetParam().model());
    expect_same_samples(found, view_, tolerance);
    expect_same_attributes(found, view_);
  }

  const RangeView view_ = coloured_view(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Cameras, VtkConversionOfViews,
                         ::testing::ValuesIn(cameras_of_all_models()), testing::PrintedName());

TEST_P(VtkConversionOfViews, ImagesGiveThemBack) { expect_view_back(*to_image_data(view_), 1e-14); }

TEST_P(VtkConversionOfViews, SurfacesGiveThemBack) {
  expect_view_back(*to_poly_data(view_), 1e-13);
}

TEST(VtkConversion, AnImageHoldsWhatTheSensorMeasured) {
  const RangeView view = pinhole_view();
  const auto image = to_image_data(view);
  int size[3];
  image->GetDimensions(size);
  EXPECT_EQ(size[0], 48);
  EXPECT_EQ(size[1], 36);
  const vtkIdType pixel = image->FindPoint(20.0, 15.0, 0.0);
  EXPECT_EQ(image->GetPointData()->GetArray("range")->GetComponent(pixel, 0), view.range(20, 15));
  EXPECT_EQ(image->GetPointData()->GetArray("mask")->GetComponent(pixel, 0), 1.0);
  EXPECT_EQ(image->GetPointData()->GetArray("mask")->GetComponent(0, 0), 0.0);
  EXPECT_EQ(image->GetPointData()->GetArray("normals")->GetComponent(pixel, 2),
            view.normals(20, 15).z());
}

TEST(VtkConversion, ASurfaceIsInTheWorld) {
  const RangeView view = pinhole_view();
  const auto surface = to_poly_data(view);
  EXPECT_EQ(static_cast<std::size_t>(surface->GetNumberOfPoints()), view.sample_count());
  EXPECT_EQ(static_cast<std::size_t>(surface->GetNumberOfPolys()),
            mesh_from_view(view).faces.size());
  const auto* pixel = surface->GetPointData()->GetArray("pixel");
  const int u = static_cast<int>(const_cast<vtkDataArray*>(pixel)->GetComponent(100, 0));
  const int v = static_cast<int>(const_cast<vtkDataArray*>(pixel)->GetComponent(100, 1));
  const Eigen::Vector3d point = Eigen::Vector3d::Map(surface->GetPoint(100));
  EXPECT_NEAR((point - view.world_from_view * view.point(u, v)).norm(), 0.0, 1e-12);
}

TEST(VtkConversion, WhatAViewDoesNotHaveStaysAway) {
  RangeView bare = pinhole_view();
  bare.normals = {};
  bare.confidence = {};
  bare.deviation = {};
  bare.colours = {};
  bare.pose = PoseKind::kAbsent;
  for (const vtkSmartPointer<vtkDataSet>& data :
       {vtkSmartPointer<vtkDataSet>(to_image_data(bare)),
        vtkSmartPointer<vtkDataSet>(to_poly_data(bare))}) {
    const auto found = value_of(to_range_view(*data));
    EXPECT_FALSE(found.has_normals());
    EXPECT_TRUE(found.confidence.empty() && found.deviation.empty() && found.colours.empty());
    EXPECT_EQ(found.pose, PoseKind::kAbsent);
  }
}

TEST(VtkConversion, AMaskTakesSamplesAway) {
  const RangeView view = pinhole_view();
  const auto image = to_image_data(view);
  image->GetPointData()->GetArray("mask")->SetComponent(image->FindPoint(20, 15, 0), 0, 0.0);
  const auto found = value_of(to_range_view(*image));
  EXPECT_EQ(found.sample_count() + 1, view.sample_count());
  EXPECT_FALSE(found.has_sample(20, 15));
}

TEST(VtkConversion, ASurfaceWithoutACameraGetsOne) {
  const RangeView view = pinhole_view();
  const auto surface = to_poly_data(view);
  surface->GetFieldData()->RemoveArray("camera_model");
  const auto found = value_of(to_range_view(*surface));
  EXPECT_EQ(found.camera.model(), Camera::Model::kPinhole);
  expect_same_samples(found, view, 1e-9);
}

TEST(VtkConversion, NamesWhatIsWrongWithAnImage) {
  const auto read = [](const char* point_array, const char* field_array) {
    const auto image = to_image_data(pinhole_view());
    image->GetPointData()->RemoveArray(point_array);
    image->GetFieldData()->RemoveArray(field_array);
    return to_range_view(*image);
  };
  EXPECT_THAT(read("range", ""), HasError("no point array 'range'"));
  EXPECT_THAT(read("", "camera_model"), HasError("no camera"));
  EXPECT_THAT(read("", "camera"), HasError("no array 'camera'"));
  EXPECT_THAT(to_range_view(*vtkNew<vtkImageData>()), HasError("empty"));
  EXPECT_THAT(to_range_view(*vtkNew<vtkUnstructuredGrid>()), HasError("vtkUnstructuredGrid"));
}

TEST(VtkConversion, NamesArraysOfTheWrongSizeOrContent) {
  const auto image = to_image_data(pinhole_view());
  vtkNew<vtkFloatArray> normals;
  normals->SetName("normals");
  normals->SetNumberOfComponents(3);
  normals->SetNumberOfTuples(7);
  image->GetPointData()->AddArray(normals);
  EXPECT_THAT(to_range_view(*image), HasError("'normals' has 7 x 3 numbers"));
  const auto other = to_image_data(pinhole_view());
  other->GetFieldData()->GetArray("world_from_view")->SetComponent(0, 0, 5.0);
  EXPECT_THAT(to_range_view(*other), HasError("world_from_view"));
  other->GetFieldData()->GetArray("camera")->SetComponent(0, 0,
                                                          std::numeric_limits<double>::infinity());
  EXPECT_THAT(to_range_view(*other), HasError("no number"));
  other->GetFieldData()->GetArray("camera")->SetComponent(0, 0, 0.0);
  EXPECT_THAT(to_range_view(*other), HasError("focal length"));
}

TEST(VtkConversion, NamesWhatIsWrongWithASurface) {
  EXPECT_THAT(to_range_view(*vtkNew<vtkPolyData>()), HasError("grid_size"));
  const auto surface = to_poly_data(pinhole_view());
  surface->GetPointData()->GetArray("pixel")->SetComponent(3, 0, 48.0);
  EXPECT_THAT(to_range_view(*surface), HasError("pixel of point 3"));
  surface->GetPointData()->RemoveArray("pixel");
  EXPECT_THAT(to_range_view(*surface), HasError("'pixel'"));
}

TEST(VtkConversion, GivesMeshesBack) {
  const TriangleMesh mesh = mesh_with_attributes();
  const auto data = to_poly_data(mesh);
  EXPECT_NE(data->GetPointData()->GetNormals(), nullptr);
  const auto found = value_of(to_triangle_mesh(*data));
  expect_same_mesh(found, mesh, 0.0);
}

TEST(VtkConversion, FilesOfVtkAreReadInEveryEncoding) {
  const testing::TemporaryFolder folder;
  const TriangleMesh mesh = mesh_with_attributes();
  for (int variant = 0; variant < 48; ++variant) {
    SCOPED_TRACE(variant);
    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetInputData(to_poly_data(mesh));
    writer->SetFileName((folder / "a.vtp").c_str());
    writer->SetDataMode(variant % 3);
    writer->SetEncodeAppendedData(variant / 3 % 2);
    writer->SetCompressorType(variant / 6 % 2 ? vtkXMLWriter::ZLIB : vtkXMLWriter::NONE);
    writer->SetHeaderType(variant / 12 % 2 ? vtkXMLWriter::UInt64 : vtkXMLWriter::UInt32);
    writer->SetByteOrder(variant / 24 % 2);
    writer->SetBlockSize(1000);
    ASSERT_EQ(writer->Write(), 1);
    const auto read = value_of(read_mesh(folder / "a.vtp"));
    expect_same_mesh(read, mesh, 1e-5);
  }
}

// Many blocks of compressed data.
TEST(VtkConversion, LargeFilesOfVtkAreRead) {
  const testing::TemporaryFolder folder;
  const TriangleMesh mesh = mesh_from_view(pinhole_view());
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(to_poly_data(mesh));
  writer->SetFileName((folder / "a.vtp").c_str());
  writer->SetBlockSize(1000);
  ASSERT_EQ(writer->Write(), 1);
  const auto read = value_of(read_mesh(folder / "a.vtp"));
  EXPECT_EQ(read.vertices, mesh.vertices);
  EXPECT_EQ(read.faces, mesh.faces);
}

TEST(VtkConversion, StripsBecomeTriangles) {
  const auto data = to_poly_data(mesh_with_attributes());
  vtkNew<vtkCellArray> strips;
  strips->InsertNextCell({0, 1, 2, 3});
  data->SetPolys(nullptr);
  data->SetStrips(strips);
  const auto found = value_of(to_triangle_mesh(*data));
  EXPECT_EQ(found.faces, (PagedVector<TriangleMesh::Face>{{0, 1, 2}, {2, 1, 3}}));
  strips->InsertNextCell({0, 1, 7});
  EXPECT_THAT(to_triangle_mesh(*data), HasError("cell 1: vertex index 7 of 4"));
}

TEST(VtkConversion, PosesAreMatrices) {
  const RigidMotion pose = pinhole_view().world_from_view;
  const auto matrix = to_vtk_matrices({pose}).front();
  EXPECT_EQ(matrix->GetElement(1, 3), pose.translation().y());
  const auto found = value_of(to_rigid_motion(*matrix));
  EXPECT_TRUE(found.isApprox(pose, 1e-14));
  matrix->SetElement(0, 0, 2.0);
  EXPECT_THAT(to_rigid_motion(*matrix), HasError("vtkMatrix4x4"));
}

}  // namespace
}  // namespace relief::interop
