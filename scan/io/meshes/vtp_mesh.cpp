// VTP is written by VTK. (Its readers of OBJ, STL and VTP are not used: they crash on damaged
// files.)
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <utility>

#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLPolyDataWriter.h>

#include "scan/base/memory/paged_fill.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/meshes/mesh_codecs.h"
#include "scan/io/meshes/poly_data_private.h"
#include "scan/io/meshes/vtp_file.h"

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

// The parts of a reader report on the console, by a setting of the whole process: one reader at a
// time, in silence.
class SilentVtk {
 public:
  SilentVtk() : lock_(mutex()), display_(vtkObject::GetGlobalWarningDisplay()) {
    vtkObject::GlobalWarningDisplayOff();
  }
  SilentVtk(const SilentVtk&) = delete;
  SilentVtk& operator=(const SilentVtk&) = delete;
  ~SilentVtk() { vtkObject::SetGlobalWarningDisplay(display_); }

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::scoped_lock<std::mutex> lock_;
  vtkTypeBool display_;
};

// The last line of VTK's several: the first ones name its source file.
std::string reason(const std::string& complaint) {
  std::string text = complaint;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const auto colon = text.find("): ");
  return colon == std::string::npos ? text : text.substr(colon + 3);
}

// The DataArray of that name in a nested element, any name if empty; null when there is none.
vtkXMLDataElement* find_data(vtkXMLDataElement& piece, const char* group, const std::string& name) {
  vtkXMLDataElement* element = piece.FindNestedElementWithName(group);
  for (int i = 0; element && i < element->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* array = element->GetNestedElement(i);
    const char* given = array->GetAttribute("Name");
    if (name.empty() || (given && name == given)) return array;
  }
  return nullptr;
}

std::size_t count_of(vtkXMLDataElement& element, const char* name, std::size_t none) {
  const char* text = element.GetAttribute(name);
  return text ? std::strtoull(text, nullptr, 10) : none;
}

Result<void> read_points(const VtpFile& file, vtkXMLDataElement& piece, std::size_t count,
                         vtkPolyData& data) {
  vtkXMLDataElement* array = find_data(piece, "Points", "");
  if (!array) return bad_input(file.path(), "damaged VTP: a piece has no points");
  const auto values = file.values(*array, 3 * count);
  if (!values) return values.error();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(count));
  for (std::size_t i = 0; i < count; ++i)
    points->SetPoint(static_cast<vtkIdType>(i), values->data() + 3 * i);
  data.SetPoints(points);
  return {};
}

Result<vtkSmartPointer<vtkCellArray>> read_cells(const VtpFile& file, vtkXMLDataElement& piece,
                                                 const char* group, std::size_t count) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  if (count == 0) return cells;
  vtkXMLDataElement* ends = find_data(piece, group, "offsets");
  vtkXMLDataElement* corners = find_data(piece, group, "connectivity");
  if (!ends || !corners) return bad_input(file.path(), "damaged VTP: a piece has no cells");
  const auto offsets = file.values(*ends, count);
  if (!offsets) return offsets.error();
  const auto most = static_cast<double>(file.most_values());
  // Written so that a NaN is out of order.
  const bool ordered = std::adjacent_find(offsets->begin(), offsets->end(), [](double a, double b) {
                         return !(a <= b);
                       }) == offsets->end();
  if (!ordered || !(offsets->front() >= 0.0) || !(offsets->back() <= most))
    return bad_input(file.path(), "damaged VTP: the offsets of its cells are damaged");
  const auto indices = file.values(*corners, static_cast<std::size_t>(offsets->back()));
  if (!indices) return indices.error();
  std::size_t at = 0;
  for (const double end : *offsets) {
    cells->InsertNextCell(static_cast<int>(static_cast<std::size_t>(end) - at));
    for (; at < static_cast<std::size_t>(end); ++at)
      cells->InsertCellPoint(std::abs((*indices)[at]) <= most
                                 ? static_cast<vtkIdType>((*indices)[at])
                                 : vtkIdType{-1});
  }
  return cells;
}

// Also says which are the normals.
Result<void> read_point_data(const VtpFile& file, vtkXMLDataElement& piece, std::size_t count,
                             vtkPolyData& data) {
  vtkXMLDataElement* arrays = piece.FindNestedElementWithName("PointData");
  const char* normals = arrays ? arrays->GetAttribute("Normals") : nullptr;
  for (const std::string name :
       {normals ? normals : "normals", "quality", "views", "source_view", "filled", "RGB"}) {
    vtkXMLDataElement* array = find_data(piece, "PointData", name);
    if (!array) continue;
    const std::size_t components = count_of(*array, "NumberOfComponents", 1);
    if (components != 1 && components != 3) continue;
    const auto values = file.values(*array, components * count);
    if (!values) return values.error();
    vtkNew<vtkDoubleArray> numbers;
    numbers->SetName(name.c_str());
    numbers->SetNumberOfComponents(static_cast<int>(components));
    numbers->SetNumberOfTuples(static_cast<vtkIdType>(count));
    std::copy(values->begin(), values->end(), numbers->GetPointer(0));
    data.GetPointData()->AddArray(numbers);
  }
  if (normals) data.GetPointData()->SetActiveNormals(normals);
  return {};
}

Result<TriangleMesh> read_piece(const VtpFile& file, vtkXMLDataElement& piece) {
  const std::size_t count = count_of(piece, "NumberOfPoints", 0);
  if (count > file.most_values() / 3)
    return bad_input(file.path(), "truncated VTP: its header promises more than the file can hold");
  vtkNew<vtkPolyData> data;
  if (count == 0) return TriangleMesh();
  if (auto read = read_points(file, piece, count, *data); !read) return read.error();
  const auto polys = read_cells(file, piece, "Polys", count_of(piece, "NumberOfPolys", 0));
  if (!polys) return polys.error();
  const auto strips = read_cells(file, piece, "Strips", count_of(piece, "NumberOfStrips", 0));
  if (!strips) return strips.error();
  data->SetPolys(*polys);
  data->SetStrips(*strips);
  if (auto read = read_point_data(file, piece, count, *data); !read) return read.error();
  auto mesh = mesh_of(*data);
  if (!mesh) return bad_input(file.path(), mesh.error().message);
  return mesh;
}

// Attributes that only some pieces have are dropped.
void append_piece(const TriangleMesh& piece, TriangleMesh& mesh) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  append_paged(piece.vertices, mesh.vertices);
  for (const auto& face : piece.faces)
    mesh.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  const auto add = [&](const auto& more, auto& values) {
    append_paged(more, values);
    if (values.size() != mesh.vertices.size()) values.clear();
  };
  add(piece.normals, mesh.normals);
  add(piece.quality, mesh.quality);
  add(piece.views, mesh.views);
  add(piece.source_views, mesh.source_views);
  add(piece.filled, mesh.filled);
  add(piece.colours, mesh.colours);
}

Result<TriangleMesh> decode_vtp_mesh(std::string content, const std::filesystem::path& path) {
  const SilentVtk silence;
  const auto file = VtpFile::parse(std::move(content), path);
  if (!file) return file.error();
  vtkXMLDataElement* data = file->root().FindNestedElementWithName("PolyData");
  if (!data) return bad_input(path, "a VTK file without PolyData");
  TriangleMesh mesh;
  for (int i = 0; i < data->GetNumberOfNestedElements(); ++i) {
    auto piece = read_piece(*file, *data->GetNestedElement(i));
    if (!piece) return piece;
    if (mesh.vertices.empty())
      mesh = std::move(*piece);
    else
      append_piece(*piece, mesh);
  }
  if (mesh.vertices.empty()) return bad_input(path, "a VTP without points");
  return mesh;
}

}  // namespace

Result<TriangleMesh> read_vtp_mesh(const std::filesystem::path& path) {
  auto content = read_file(path);
  if (!content) return content.error();
  try {
    return decode_vtp_mesh(std::move(*content), path);
  } catch (const std::exception& exception) {
    return bad_input(path, std::string("damaged VTP: ") + exception.what());
  }
}

Result<std::string> encode_vtp_mesh(const TriangleMesh& mesh) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  const auto vtk_errors = observe(writer);
  writer->SetInputData(poly_data_of(mesh, needs_doubles(mesh)));
  writer->WriteToOutputStringOn();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (writer->Write() != 1 || !vtk_errors->text.empty())
    return Error{ErrorKind::kCannotWrite, "VTK: " + reason(vtk_errors->text)};
  return writer->GetOutputString();
}

}  // namespace relief
