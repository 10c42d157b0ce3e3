// The one file of this folder that meets VTK. (Its readers of OBJ and STL are not used: they crash
// on damaged files.)
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkXMLPolyDataWriter.h>

#include "scan/io/meshes/mesh_codecs.h"

namespace relief {

namespace {

// Keeps what a VTK object reports, instead of its printing it on standard error.
class VtkErrorObserver : public vtkCommand {
 public:
  static VtkErrorObserver* New() { return new VtkErrorObserver; }
  void Execute(vtkObject*, unsigned long event, void* data) override {
    if (event == vtkCommand::ErrorEvent && data) text = static_cast<const char*>(data);
  }
  std::string text;
};

vtkSmartPointer<VtkErrorObserver> observe(vtkObject* object) {
  auto vtk_errors = vtkSmartPointer<VtkErrorObserver>::New();
  object->AddObserver(vtkCommand::ErrorEvent, vtk_errors);
  object->AddObserver(vtkCommand::WarningEvent, vtk_errors);
  return vtk_errors;
}

// The last line of VTK's several: the first ones name its source file.
std::string reason(const std::string& complaint) {
  std::string text = complaint;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const auto colon = text.find("): ");
  return colon == std::string::npos ? text : text.substr(colon + 3);
}

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

vtkSmartPointer<vtkPolyData> poly_data_of(const TriangleMesh& mesh) {
  vtkNew<vtkPoints> points;
  if (needs_doubles(mesh)) points->SetDataTypeToDouble();
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
  add_attribute<vtkUnsignedCharArray>(data, "filled", 1, mesh.filled.size(),
                                      [&](std::size_t i, int) { return mesh.filled[i]; });
  add_attribute<vtkUnsignedCharArray>(
      data, "RGB", 3, mesh.colours.size(),
      [&](std::size_t i, int c) { return mesh.colours[i][static_cast<std::size_t>(c)]; });
  if (!mesh.normals.empty()) data->GetPointData()->SetActiveNormals("normals");
  return data;
}

}  // namespace

Result<std::string> encode_vtp_mesh(const TriangleMesh& mesh) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  const auto vtk_errors = observe(writer);
  writer->SetInputData(poly_data_of(mesh));
  writer->WriteToOutputStringOn();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (writer->Write() != 1 || !vtk_errors->text.empty())
    return Error{ErrorKind::kCannotWrite, "VTK: " + reason(vtk_errors->text)};
  return writer->GetOutputString();
}

}  // namespace relief
