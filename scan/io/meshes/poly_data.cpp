#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>

#include "scan/io/meshes/poly_data_private.h"

namespace relief {

namespace {

// A point attribute of `Array` with `components` values for each of `count` points.
template <typename Array, typename Get>
void add_attribute(vtkPolyData* data, const char* name, int components, std::size_t count,
                   const Get& get) {
  if (count == 0) return;
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < components; ++c)
      array->SetTypedComponent(static_cast<vtkIdType>(i), c, get(i, c));
  data->GetPointData()->AddArray(array);
}

Error damaged(const std::string& what) { return {ErrorKind::kBadInput, what}; }

Result<void> read_vertices(vtkPolyData& data, TriangleMesh& mesh) {
  mesh.vertices.resize(static_cast<std::size_t>(data.GetNumberOfPoints()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    data.GetPoint(static_cast<vtkIdType>(i), mesh.vertices[i].data());
    if (!mesh.vertices[i].allFinite())
      return damaged("vertex " + std::to_string(i) + " is not finite");
  }
  return {};
}

// The corners of a cell become a fan, or a strip whose every other triangle is turned round.
void append_triangles(vtkIdList& corners, bool strip, PagedVector<TriangleMesh::Face>& faces) {
  const auto corner = [&](vtkIdType k) { return static_cast<std::uint32_t>(corners.GetId(k)); };
  for (vtkIdType k = 2; k < corners.GetNumberOfIds(); ++k) {
    if (!strip)
      faces.push_back({corner(0), corner(k - 1), corner(k)});
    else if (k % 2 == 0)
      faces.push_back({corner(k - 2), corner(k - 1), corner(k)});
    else
      faces.push_back({corner(k - 1), corner(k - 2), corner(k)});
  }
}

Result<void> read_cells(vtkCellArray* cells, bool strips, TriangleMesh& mesh) {
  if (!cells || cells->GetNumberOfCells() == 0) return {};
  if (!cells->IsValid()) return damaged("the offsets of its cells are damaged");
  const auto vertices = static_cast<vtkIdType>(mesh.vertices.size());
  vtkNew<vtkIdList> corners;
  for (vtkIdType cell = 0; cell < cells->GetNumberOfCells(); ++cell) {
    cells->GetCellAtId(cell, corners);
    for (vtkIdType k = 0; k < corners->GetNumberOfIds(); ++k)
      if (corners->GetId(k) < 0 || corners->GetId(k) >= vertices)
        return damaged("cell " + std::to_string(cell) + ": vertex index " +
                       std::to_string(corners->GetId(k)) + " of " + std::to_string(vertices));
    append_triangles(*corners, strips, mesh.faces);
  }
  return {};
}

bool fits(const vtkDataArray* array, const TriangleMesh& mesh, int components) {
  return array && array->GetNumberOfComponents() == components &&
         static_cast<std::size_t>(array->GetNumberOfTuples()) == mesh.vertices.size();
}

template <typename T>
T rounded(double value) {
  const double largest = std::numeric_limits<T>::max();
  return value > 0.0 ? static_cast<T>(std::min(std::round(value), largest)) : T{0};
}

// Fills `values` by `get(i)` where the array of that name fits.
template <typename T, typename Get>
void read_attribute(vtkDataArray* array, int components, const TriangleMesh& mesh,
                    PagedVector<T>& values, const Get& get) {
  if (!fits(array, mesh, components)) return;
  values.reserve(mesh.vertices.size());
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) values.push_back(get(i));
}

Eigen::Vector3f vector_at(vtkDataArray* array, vtkIdType i) {
  Eigen::Vector3d vector;
  array->GetTuple(i, vector.data());
  return vector.cast<float>();
}

void read_attributes(vtkPointData& data, TriangleMesh& mesh) {
  vtkDataArray* normals = data.GetNormals() ? data.GetNormals() : data.GetArray("normals");
  vtkDataArray* quality = data.GetArray("quality");
  vtkDataArray* views = data.GetArray("views");
  vtkDataArray* sources = data.GetArray("source_view");
  vtkDataArray* filled = data.GetArray("filled");
  vtkDataArray* colours = data.GetArray("RGB");
  read_attribute(normals, 3, mesh, mesh.normals, [&](auto i) { return vector_at(normals, i); });
  read_attribute(quality, 1, mesh, mesh.quality,
                 [&](auto i) { return static_cast<float>(quality->GetComponent(i, 0)); });
  read_attribute(views, 1, mesh, mesh.views,
                 [&](auto i) { return rounded<std::uint16_t>(views->GetComponent(i, 0)); });
  read_attribute(sources, 1, mesh, mesh.source_views,
                 [&](auto i) { return rounded<std::uint16_t>(sources->GetComponent(i, 0)); });
  read_attribute(filled, 1, mesh, mesh.filled, [&](auto i) {
    return static_cast<std::uint8_t>(filled->GetComponent(i, 0) != 0.0);
  });
  read_attribute(colours, 3, mesh, mesh.colours, [&](auto i) {
    return Colour{rounded<std::uint8_t>(colours->GetComponent(i, 0)),
                  rounded<std::uint8_t>(colours->GetComponent(i, 1)),
                  rounded<std::uint8_t>(colours->GetComponent(i, 2))};
  });
}

}  // namespace

vtkSmartPointer<vtkPolyData> poly_data_of(const TriangleMesh& mesh, bool doubles) {
  vtkNew<vtkPoints> points;
  if (doubles) points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    points->SetPoint(static_cast<vtkIdType>(i), mesh.vertices[i].data());
  vtkNew<vtkCellArray> faces;
  faces->AllocateExact(static_cast<vtkIdType>(mesh.faces.size()),
                       static_cast<vtkIdType>(3 * mesh.faces.size()));
  for (const auto& face : mesh.faces) faces->InsertNextCell({face[0], face[1], face[2]});
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(faces);
  add_attribute<vtkFloatArray>(data, "normals", 3, mesh.normals.size(),
                               [&](std::size_t i, int c) { return mesh.normals[i][c]; });
  add_attribute<vtkFloatArray>(data, "quality", 1, mesh.quality.size(),
                               [&](std::size_t i, int) { return mesh.quality[i]; });
  add_attribute<vtkUnsignedShortArray>(data, "views", 1, mesh.views.size(),
                                       [&](std::size_t i, int) { return mesh.views[i]; });
  add_attribute<vtkUnsignedShortArray>(data, "source_view", 1, mesh.source_views.size(),
                                       [&](std::size_t i, int) { return mesh.source_views[i]; });
  add_attribute<vtkUnsignedCharArray>(data, "filled", 1, mesh.filled.size(),
                                      [&](std::size_t i, int) { return mesh.filled[i]; });
  add_attribute<vtkUnsignedCharArray>(
      data, "RGB", 3, mesh.colours.size(),
      [&](std::size_t i, int c) { return mesh.colours[i][static_cast<std::size_t>(c)]; });
  if (!mesh.normals.empty()) data->GetPointData()->SetActiveNormals("normals");
  return data;
}

Result<TriangleMesh> mesh_of(vtkPolyData& data) {
  TriangleMesh mesh;
  if (auto read = read_vertices(data, mesh); !read) return read.error();
  if (auto read = read_cells(data.GetPolys(), false, mesh); !read) return read.error();
  if (auto read = read_cells(data.GetStrips(), true, mesh); !read) return read.error();
  read_attributes(*data.GetPointData(), mesh);
  return mesh;
}

}  // namespace relief
