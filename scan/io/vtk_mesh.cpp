// The one file of this folder that meets VTK.
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkXMLPolyDataWriter.h>

#include "scan/io/io_error.h"
#include "scan/io/mesh_codecs.h"

namespace relief {

namespace {

// Keeps what a VTK object reports, instead of its printing it on standard error.
class Complaints : public vtkCommand {
 public:
  static Complaints* New() { return new Complaints; }
  void Execute(vtkObject*, unsigned long event, void* data) override {
    if (event == vtkCommand::ErrorEvent && data) text = static_cast<const char*>(data);
  }
  std::string text;
};

vtkSmartPointer<Complaints> observe(vtkObject* object) {
  auto complaints = vtkSmartPointer<Complaints>::New();
  object->AddObserver(vtkCommand::ErrorEvent, complaints);
  object->AddObserver(vtkCommand::WarningEvent, complaints);
  return complaints;
}

// The last line of VTK's several: the first ones name its source file.
std::string reason(const std::string& complaint) {
  std::string text = complaint;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const auto colon = text.find("): ");
  return colon == std::string::npos ? text : text.substr(colon + 3);
}

Result<TriangleMesh> mesh_of(vtkPolyData* data, const std::filesystem::path& path) {
  TriangleMesh mesh;
  const vtkIdType count = data->GetNumberOfPoints();
  mesh.vertices.reserve(static_cast<std::size_t>(count));
  for (vtkIdType i = 0; i < count; ++i) {
    Eigen::Vector3d vertex;
    data->GetPoint(i, vertex.data());
    if (!vertex.allFinite())
      return bad_input(path, "vertex " + std::to_string(i) + " has a NaN or infinite coordinate");
    mesh.vertices.push_back(vertex);
  }
  auto polygon = vtk::TakeSmartPointer(data->GetPolys()->NewIterator());
  for (polygon->GoToFirstCell(); !polygon->IsDoneWithTraversal(); polygon->GoToNextCell()) {
    vtkIdType corners = 0;
    const vtkIdType* ids = nullptr;
    polygon->GetCurrentCell(corners, ids);
    for (vtkIdType k = 0; k < corners; ++k)
      if (ids[k] < 0 || ids[k] >= count)
        return bad_input(path, "face " + std::to_string(polygon->GetCurrentCellId()) +
                                   ": vertex index " + std::to_string(ids[k]) + " is outside the " +
                                   std::to_string(count) + " vertices");
    for (vtkIdType k = 1; k + 1 < corners; ++k)
      mesh.faces.push_back({static_cast<std::uint32_t>(ids[0]), static_cast<std::uint32_t>(ids[k]),
                            static_cast<std::uint32_t>(ids[k + 1])});
  }
  if (mesh.faces.empty()) return bad_input(path, "no faces: the file is empty or damaged");
  return mesh;
}

template <typename Reader>
Result<TriangleMesh> read_with(Reader* reader, const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return bad_input(path, "no such file");
  const auto complaints = observe(reader);
  reader->SetFileName(path.c_str());
  reader->Update();
  if (!complaints->text.empty() || reader->GetErrorCode() != vtkErrorCode::NoError)
    return bad_input(
        path, "damaged mesh: " + (complaints->text.empty()
                                      ? vtkErrorCode::GetStringFromErrorCode(reader->GetErrorCode())
                                      : reason(complaints->text)));
  return mesh_of(reader->GetOutput(), path);
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
  if (!mesh.normals.empty()) data->GetPointData()->SetActiveNormals("normals");
  return data;
}

}  // namespace

Result<TriangleMesh> read_obj_mesh(const std::filesystem::path& path) {
  vtkNew<vtkOBJReader> reader;
  return read_with(reader.Get(), path);
}

Result<TriangleMesh> read_stl_mesh(const std::filesystem::path& path) {
  vtkNew<vtkSTLReader> reader;
  reader->MergingOn();
  return read_with(reader.Get(), path);
}

Result<std::string> encode_vtp_mesh(const TriangleMesh& mesh) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  const auto complaints = observe(writer);
  writer->SetInputData(poly_data_of(mesh));
  writer->WriteToOutputStringOn();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (writer->Write() != 1 || !complaints->text.empty())
    return Error{ErrorKind::kCannotWrite, "VTK: " + reason(complaints->text)};
  return writer->GetOutputString();
}

}  // namespace relief
