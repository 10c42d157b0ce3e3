#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include <pugixml.hpp>

#include "scan/base/counter_random.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/e57/e57_pages.h"
#include "scan/io/e57/e57_section_writer.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/binary_writer.h"

namespace relief {

namespace {

constexpr const char* kStandardUri = "http://www.astm.org/COMMIT/E57/2010-e57-v1.0";
constexpr const char* kNormalsUri = "http://www.libe57.org/E57_NOR_surface_normals.txt";

// Two hashes of some bytes as a guid, so that the same views give the same one.
std::string guid_of(std::string_view bytes) {
  std::array<std::uint64_t, 2> hashes{1, 2};
  for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(8, bytes.size()))) {
    char word[8] = {};
    bytes.copy(word, 8);
    for (std::uint64_t& hash : hashes)
      hash = CounterRandom::scrambled(hash * 0x9e3779b97f4a7c15ull +
                                      e57_number_at<std::uint64_t>(word));
  }
  std::string text = "{";
  for (std::size_t digit = 0; digit < 32; ++digit) {
    if (digit == 8 || digit == 12 || digit == 16 || digit == 20) text += '-';
    text += "0123456789abcdef"[hashes[digit / 16] >> (4 * (digit % 16)) & 15u];
  }
  return text + "}";
}

// How many bytes the UTF-8 character at the start of a text has; 0 when it is none.
std::size_t character_bytes(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const std::size_t bytes = lead < 0x80                   ? 1
                            : lead >= 0xc2 && lead < 0xe0 ? 2
                            : lead >= 0xe0 && lead < 0xf0 ? 3
                            : lead >= 0xf0 && lead < 0xf5 ? 4
                                                          : 0;
  if (bytes == 0 || bytes > text.size()) return 0;
  for (std::size_t i = 1; i < bytes; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return 0;
  return bytes;
}

// What XML cannot hold becomes an underscore.
std::string xml_text(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t bytes = character_bytes(text);
    const bool control = static_cast<unsigned char>(text.front()) < 0x20;
    if (bytes == 0 || control)
      clean += '_';
    else
      clean += text.substr(0, bytes);
    text.remove_prefix(std::max<std::size_t>(bytes, 1));
  }
  return clean;
}

// The shortest text that reads back as the same number.
std::string shortest(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

pugi::xml_node add_node(pugi::xml_node parent, const std::string& name, const char* type) {
  pugi::xml_node node = parent.append_child(name.c_str());
  node.append_attribute("type") = type;
  return node;
}

void add_string(pugi::xml_node parent, const char* name, const std::string& text) {
  add_node(parent, name, "String").append_child(pugi::node_cdata).set_value(text.c_str());
}

void add_number(pugi::xml_node parent, const std::string& name, const char* type,
                const std::string& text) {
  add_node(parent, name, type).append_child(pugi::node_pcdata).set_value(text.c_str());
}

void add_integer(pugi::xml_node parent, const std::string& name, int value) {
  add_number(parent, name, "Integer", std::to_string(value));
}

void add_float(pugi::xml_node parent, const std::string& name, double value) {
  add_number(parent, name, "Float", shortest(value));
}

void add_vector_attribute(pugi::xml_node node) {
  node.append_attribute("allowHeterogeneousChildren") = "1";
}

void add_bounds(pugi::xml_node scan, const E57RecordPlan& plan) {
  const pugi::xml_node index = add_node(scan, "indexBounds", "Structure");
  add_integer(index, "rowMinimum", 0);
  add_integer(index, "rowMaximum", plan.view->height() - 1);
  add_integer(index, "columnMinimum", 0);
  add_integer(index, "columnMaximum", plan.view->width() - 1);
  add_integer(index, "returnMinimum", 0);
  add_integer(index, "returnMaximum", 0);
  if (plan.pixels.empty()) return;
  const pugi::xml_node cartesian = add_node(scan, "cartesianBounds", "Structure");
  for (int k = 0; k < 3; ++k) {
    const std::string axis(1, "xyz"[k]);
    add_float(cartesian, axis + "Minimum", plan.low[k]);
    add_float(cartesian, axis + "Maximum", plan.high[k]);
  }
}

void add_colour_limits(pugi::xml_node scan) {
  const pugi::xml_node limits = add_node(scan, "colorLimits", "Structure");
  for (const char* colour : {"colorRed", "colorGreen", "colorBlue"}) {
    add_integer(limits, std::string(colour) + "Minimum", 0);
    add_integer(limits, std::string(colour) + "Maximum", 255);
  }
}

void add_pose(pugi::xml_node scan, const RigidMotion& world_from_view, double metres_per_unit) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(world_from_view.linear()).normalized();
  const pugi::xml_node pose = add_node(scan, "pose", "Structure");
  const pugi::xml_node rotation = add_node(pose, "rotation", "Structure");
  add_float(rotation, "w", q.w());
  add_float(rotation, "x", q.x());
  add_float(rotation, "y", q.y());
  add_float(rotation, "z", q.z());
  const pugi::xml_node translation = add_node(pose, "translation", "Structure");
  for (int k = 0; k < 3; ++k)
    add_float(translation, std::string(1, "xyz"[k]),
              world_from_view.translation()[k] * metres_per_unit);
}

void add_integer_field(pugi::xml_node prototype, const char* name, int maximum) {
  pugi::xml_node field = add_node(prototype, name, "Integer");
  field.append_attribute("minimum") = 0;
  field.append_attribute("maximum") = maximum;
}

// In the order of streams_of.
void add_prototype(pugi::xml_node points, const RangeView& view) {
  const pugi::xml_node prototype = add_node(points, "prototype", "Structure");
  for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
    add_node(prototype, name, "Float").append_attribute("precision") = "double";
  add_integer_field(prototype, "rowIndex", view.height() - 1);
  add_integer_field(prototype, "columnIndex", view.width() - 1);
  if (!view.colours.empty())
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
      add_integer_field(prototype, name, 255);
  if (!view.has_normals()) return;
  for (const char* name : {"nor:normalX", "nor:normalY", "nor:normalZ"}) {
    pugi::xml_node field = add_node(prototype, name, "Float");
    field.append_attribute("precision") = "single";
    field.append_attribute("minimum") = "-1";
    field.append_attribute("maximum") = "1";
  }
}

void add_scan(pugi::xml_node scans, const E57RecordPlan& plan, std::size_t section,
              const std::string& guid) {
  const RangeView& view = *plan.view;
  const pugi::xml_node scan = add_node(scans, "vectorChild", "Structure");
  add_string(scan, "guid", guid);
  add_string(scan, "name", xml_text(view.name));
  add_bounds(scan, plan);
  if (!view.colours.empty()) add_colour_limits(scan);
  if (view.pose != PoseKind::kAbsent) add_pose(scan, view.world_from_view, plan.metres_per_unit);
  pugi::xml_node points = add_node(scan, "points", "CompressedVector");
  points.append_attribute("fileOffset") = static_cast<unsigned long long>(e57_physical(section));
  points.append_attribute("recordCount") = static_cast<unsigned long long>(plan.pixels.size());
  add_prototype(points, view);
  add_vector_attribute(add_node(points, "codecs", "Vector"));
}

struct StringSink : pugi::xml_writer {
  void write(const void* data, std::size_t size) override {
    text.append(static_cast<const char*>(data), size);
  }
  std::string text;
};

std::string header_of(std::size_t xml_start, std::size_t xml_bytes, std::size_t pages) {
  std::string header = "ASTM-E57";
  append_little_endian(header, std::uint32_t{1});
  append_little_endian(header, std::uint32_t{0});
  append_little_endian(header, static_cast<std::uint64_t>(pages * kE57PageBytes));
  append_little_endian(header, e57_physical(xml_start));
  append_little_endian(header, static_cast<std::uint64_t>(xml_bytes));
  append_little_endian(header, kE57PageBytes);
  return header;
}

// The root element with everything but the scans; returns their vector.
pugi::xml_node add_root(pugi::xml_document& document, const std::string& guid) {
  document.load_string("<?xml version=\"1.0\" encoding=\"UTF-8\"?>", pugi::parse_full);
  pugi::xml_node root = add_node(document, "e57Root", "Structure");
  root.append_attribute("xmlns") = kStandardUri;
  root.append_attribute("xmlns:nor") = kNormalsUri;
  add_string(root, "formatName", "ASTM E57 3D Imaging Data File");
  add_string(root, "guid", guid);
  add_integer(root, "versionMajor", 1);
  add_integer(root, "versionMinor", 0);
  add_string(root, "e57LibraryVersion", "relief");
  pugi::xml_node scans = add_node(root, "data3D", "Vector");
  add_vector_attribute(scans);
  add_vector_attribute(add_node(root, "images2D", "Vector"));
  return scans;
}

}  // namespace

Result<std::string> encode_e57(const std::vector<RangeView>& views, double metres_per_unit) {
  if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit))
    return Error{ErrorKind::kBadInput,
                 "an E57 file is in metres: metres per unit must be a "
                 "positive number, not " +
                     shortest(metres_per_unit)};
  std::string payload(kE57HeaderBytes, '\0');
  pugi::xml_document scans;
  for (const RangeView& view : views) {
    const E57RecordPlan plan = plan_e57_records(view, metres_per_unit);
    const std::size_t section = payload.size();
    append_e57_section(payload, plan);
    const std::string_view bytes = std::string_view(payload).substr(section);
    add_scan(scans, plan, section, guid_of(view.name + '\0' + std::string(bytes)));
  }
  pugi::xml_document document;
  pugi::xml_node vector = add_root(document, guid_of(payload));
  for (const auto& scan : scans.children()) vector.append_copy(scan);
  StringSink xml;
  document.save(xml, "  ", pugi::format_default, pugi::encoding_utf8);
  xml.text.resize((xml.text.size() + 3) / 4 * 4, '\n');
  const std::size_t start = payload.size();
  payload += xml.text;
  const std::size_t pages = (payload.size() + kE57PayloadBytes - 1) / kE57PayloadBytes;
  payload.replace(0, kE57HeaderBytes, header_of(start, xml.text.size(), pages));
  return e57_pages_from(payload);
}

Result<void> write_e57(const std::vector<RangeView>& views, const std::filesystem::path& path,
                       double metres_per_unit) {
  const auto content = encode_e57(views, metres_per_unit);
  if (!content) return content.error();
  return write_file(path, *content);
}

}  // namespace relief
