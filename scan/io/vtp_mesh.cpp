// The one file of this folder that meets VTK's files. (Its readers of OBJ and STL are not used:
// they crash on damaged files.)
#include <cstdlib>
#include <exception>
#include <mutex>
#include <sstream>

#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>

#include "scan/io/atomic_file.h"
#include "scan/io/io_error.h"
#include "scan/io/mesh_codecs.h"
#include "scan/io/poly_data_private.h"

namespace relief {

namespace {

// zlib gives at most so many bytes for one.
constexpr double kMaxCompression = 1032.0;

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

// How many numbers an element of the file's tree promises, at most.
double promised_numbers(vtkXMLDataElement& element) {
  double largest = 0.0, components = 1.0;
  for (int i = 0; i < element.GetNumberOfAttributes(); ++i) {
    const std::string name = element.GetAttributeName(i);
    const double value = std::strtod(element.GetAttributeValue(i), nullptr);
    if (name == "NumberOfComponents")
      components = std::max(components, value);
    else if (name.starts_with("NumberOf"))
      largest = std::max(largest, value);
  }
  double sum = largest * components;
  for (int i = 0; i < element.GetNumberOfNestedElements(); ++i)
    sum += promised_numbers(*element.GetNestedElement(i));
  return sum;
}

// Holds what the header promises against the size of the file, before anything is allocated for it.
Result<void> check_header(const std::string& content, const std::filesystem::path& path) {
  std::istringstream stream(content);
  vtkNew<vtkXMLDataParser> parser;
  parser->SetStream(&stream);
  if (parser->Parse() != 1 || !parser->GetRootElement())
    return bad_input(path, "damaged VTP: no well-formed XML");
  const std::string type = [&] {
    const char* text = parser->GetRootElement()->GetAttribute("type");
    return std::string(text ? text : "");
  }();
  if (type != "PolyData") return bad_input(path, "a VTK file of '" + type + "', not of PolyData");
  if (!(promised_numbers(*parser->GetRootElement()) <=
        kMaxCompression * static_cast<double>(content.size())))
    return bad_input(path, "truncated VTP: its header promises more than the file can hold");
  return {};
}

Result<TriangleMesh> decode_vtp_mesh(const std::string& content,
                                     const std::filesystem::path& path) {
  const SilentVtk silence;
  if (auto sound = check_header(content, path); !sound) return sound.error();
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(content);
  reader->Update();
  // After an error in the data the output is empty.
  if (reader->GetErrorCode() != 0 || reader->GetOutput()->GetNumberOfPoints() == 0)
    return bad_input(path, "damaged VTP, or one without points");
  auto mesh = mesh_of(*reader->GetOutput());
  if (!mesh) return bad_input(path, mesh.error().message);
  return mesh;
}

}  // namespace

Result<TriangleMesh> read_vtp_mesh(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  try {
    return decode_vtp_mesh(*content, path);
  } catch (const std::exception& exception) {
    return bad_input(path, std::string("damaged VTP: ") + exception.what());
  }
}

Result<std::string> encode_vtp_mesh(const TriangleMesh& mesh) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  const auto complaints = observe(writer);
  writer->SetInputData(poly_data_of(mesh, needs_doubles(mesh)));
  writer->WriteToOutputStringOn();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (writer->Write() != 1 || !complaints->text.empty())
    return Error{ErrorKind::kCannotWrite, "VTK: " + reason(complaints->text)};
  return writer->GetOutputString();
}

}  // namespace relief
