// The one file that meets the reader of XML.
#include "scan/io/e57/e57_layout.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include <pugixml.hpp>

#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/files/unit_quaternion.h"

namespace relief {

namespace {

constexpr int kMaxNesting = 8;            // of structures in a record
constexpr std::size_t kMaxFields = 1024;  // of a record
// The published extension, and an earlier spelling that files in use have.
constexpr std::array<std::string_view, 2> kNormalExtensions{
    "http://www.libe57.org/E57_NOR_surface_normals.txt",
    "http://www.libe57.org/E57_EXT_surface_normals.txt"};

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return is_blank(c) || c == '\n'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

bool parse_whole(std::string_view text, std::int64_t& value) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

std::string shown(std::string_view text) {
  return "'" + std::string(text.substr(0, 40)) + (text.size() > 40 ? "...'" : "'");
}

// All of an element's own text, which may be in several pieces.
std::string text_of(const pugi::xml_node& node) {
  std::string text;
  for (const auto& child : node.children())
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
      text += child.value();
  return text;
}

// The prefix, with its colon, of normals in this document; empty when it declares none.
std::string normal_prefix(const pugi::xml_node& root) {
  for (const auto& attribute : root.attributes()) {
    const std::string_view name = attribute.name();
    if (!name.starts_with("xmlns:")) continue;
    for (const std::string_view uri : kNormalExtensions)
      if (uri == attribute.value()) return std::string(name.substr(6)) + ":";
  }
  return {};
}

// Reads one scan's structure.
class E57ScanReader {
 public:
  E57ScanReader(const pugi::xml_node& node, std::size_t number, std::string prefix,
                const std::filesystem::path& path)
      : node_(node), number_(number), prefix_(std::move(prefix)), path_(path) {}

  Result<E57Scan> read() {
    scan_.name = text_of(node_.child("name"));
    scan_.guid = text_of(node_.child("guid"));
    for (auto step : {&E57ScanReader::read_points, &E57ScanReader::read_pose,
                      &E57ScanReader::read_index_bounds, &E57ScanReader::read_limits})
      if (auto done = (this->*step)(); !done) return done.error();
    return std::move(scan_);
  }

 private:
  Error damaged(const std::string& what) const {
    return bad_input(path_, "scan " + std::to_string(number_) + " of the E57: " + what);
  }

  Result<std::int64_t> whole(const pugi::xml_node& node, const char* attribute,
                             std::int64_t otherwise) const {
    const pugi::xml_attribute found = node.attribute(attribute);
    std::int64_t value = otherwise;
    if (found && !parse_whole(found.value(), value))
      return damaged(std::string(node.name()) + " has the " + attribute + " " +
                     shown(found.value()) + ", which is no integer of 64 bits");
    return value;
  }

  Result<double> real(const pugi::xml_node& node, const char* attribute, double otherwise) const {
    const pugi::xml_attribute found = node.attribute(attribute);
    double value = otherwise;
    if (found && (!parse_number(trimmed(found.value()), value) || !std::isfinite(value)))
      return damaged(std::string(node.name()) + " has the " + attribute + " " +
                     shown(found.value()) + ", which is no number");
    return value;
  }

  // The value of a number's element. An empty one stands for 0.
  Result<double> number(const pugi::xml_node& node) const {
    const std::string text = text_of(node);
    double value = 0.0;
    if (!trimmed(text).empty() && (!parse_number(trimmed(text), value) || !std::isfinite(value)))
      return damaged(std::string(node.name()) + " is " + shown(text) + ", which is no number");
    if (std::string_view(node.attribute("type").value()) != "ScaledInteger") return value;
    const auto scale = real(node, "scale", 1.0);
    const auto offset = real(node, "offset", 0.0);
    if (!scale) return scale;
    if (!offset) return offset;
    return value * *scale + *offset;
  }

  Result<void> read_points() {
    const pugi::xml_node points = node_.child("points");
    if (!points) return damaged("it has no element points");
    const auto count = whole(points, "recordCount", -1), offset = whole(points, "fileOffset", -1);
    if (!count) return count.error();
    if (!offset) return offset.error();
    if (*count < 0 || *offset < 0)
      return damaged("points needs a recordCount and a fileOffset that are not negative");
    scan_.record_count = static_cast<std::uint64_t>(*count);
    scan_.section_offset = static_cast<std::uint64_t>(*offset);
    if (auto codecs = check_codecs(points.child("codecs")); !codecs) return codecs;
    return read_fields(points.child("prototype"), "", 0);
  }

  // The standard has one codec, bit packing, which is also what is meant by none.
  Result<void> check_codecs(const pugi::xml_node& codecs) const {
    for (const auto& codec : codecs.children())
      if (codec.type() == pugi::node_element && !codec.child("bitPackCodec"))
        return damaged("its points are packed by an unknown codec; export them with bitPackCodec");
    return {};
  }

  Result<void> read_fields(const pugi::xml_node& parent, const std::string& place, int depth) {
    if (!parent) return damaged("points has no prototype");
    if (depth > kMaxNesting) return damaged("the prototype of points is nested too deeply");
    for (const auto& node : parent.children()) {
      if (node.type() != pugi::node_element) continue;
      const std::string_view type = node.attribute("type").value();
      std::string name = place + node.name();
      if (type == "Structure" || type == "Vector") {
        if (auto inner = read_fields(node, name + "/", depth + 1); !inner) return inner;
        continue;
      }
      if (scan_.fields.size() == kMaxFields)
        return damaged("a point has more than " + std::to_string(kMaxFields) + " fields");
      if (!prefix_.empty() && name.starts_with(prefix_ + "normal")) name.erase(0, prefix_.size());
      if (auto field = read_field(node, name); !field) return field;
    }
    return {};
  }

  Result<void> read_field(const pugi::xml_node& node, const std::string& name) {
    const std::string_view type = node.attribute("type").value();
    E57Field field;
    field.name = name;
    if (type == "String") {
      field.type = E57Field::Type::kText;
      scan_.fields.push_back(field);
      return {};
    }
    Result<void> read;
    if (type == "Float")
      read = read_float(node, field);
    else if (type == "Integer" || type == "ScaledInteger")
      read = read_integer(node, field, type == "ScaledInteger");
    else
      return damaged("the field " + name + " has the unknown type " + shown(type));
    if (read) scan_.fields.push_back(field);
    return read;
  }

  Result<void> read_float(const pugi::xml_node& node, E57Field& field) const {
    const std::string_view precision = node.attribute("precision").value();
    if (!precision.empty() && precision != "single" && precision != "double")
      return damaged("the field " + field.name + " has the precision " + shown(precision) +
                     ", which is neither single nor double");
    field.type = precision == "single" ? E57Field::Type::kFloat : E57Field::Type::kDouble;
    field.bits = precision == "single" ? 32 : 64;
    if (!node.attribute("minimum") || !node.attribute("maximum")) return {};
    const auto low = real(node, "minimum", 0.0), high = real(node, "maximum", 0.0);
    if (!low) return low.error();
    if (!high) return high.error();
    field.limits = E57Limits{*low, *high};
    return {};
  }

  Result<void> read_integer(const pugi::xml_node& node, E57Field& field, bool scaled) const {
    constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
    constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
    const auto minimum = whole(node, "minimum", kLeast), maximum = whole(node, "maximum", kMost);
    const auto scale = real(node, "scale", 1.0), offset = real(node, "offset", 0.0);
    if (!minimum) return minimum.error();
    if (!maximum) return maximum.error();
    if (!scale) return scale.error();
    if (!offset) return offset.error();
    if (*minimum > *maximum)
      return damaged("the field " + field.name + " has a minimum above its maximum");
    field.type = E57Field::Type::kInteger;
    field.minimum = *minimum;
    field.bits = e57_bits_between(*minimum, *maximum);
    if (scaled) field.scale = *scale, field.offset = *offset;
    field.limits = E57Limits{static_cast<double>(*minimum) * field.scale + field.offset,
                             static_cast<double>(*maximum) * field.scale + field.offset};
    return {};
  }

  // Numbers of the children `names` of `parent`; those that are missing are 0.
  template <std::size_t N>
  Result<std::array<double, N>> numbers(const pugi::xml_node& parent,
                                        const std::array<const char*, N>& names) const {
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) {
      const auto value = number(parent.child(names[i]));
      if (!value) return value.error();
      values[i] = *value;
    }
    return values;
  }

  Result<void> read_pose() {
    const pugi::xml_node pose = node_.child("pose");
    if (!pose) return {};
    const auto rotation = numbers<4>(pose.child("rotation"), {"w", "x", "y", "z"});
    const auto translation = numbers<3>(pose.child("translation"), {"x", "y", "z"});
    if (!rotation) return rotation.error();
    if (!translation) return translation.error();
    Eigen::Quaterniond q((*rotation)[0], (*rotation)[1], (*rotation)[2], (*rotation)[3]);
    if (!pose.child("rotation")) q.setIdentity();
    if (!(std::abs(q.norm() - 1.0) < kUnitQuaternion))
      return damaged("the rotation of its pose is a quaternion of length " +
                     std::to_string(q.norm()) + ", which must be 1; correct or remove the pose");
    scan_.world_from_view = RigidMotion::Identity();
    scan_.world_from_view->linear() = q.normalized().toRotationMatrix();
    scan_.world_from_view->translation() = Eigen::Vector3d(translation->data());
    return {};
  }

  Result<void> read_index_bounds() {
    const pugi::xml_node bounds = node_.child("indexBounds");
    constexpr std::array<const char*, 4> kNames{"rowMinimum", "rowMaximum", "columnMinimum",
                                                "columnMaximum"};
    std::array<std::int64_t, 4> values{};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      const pugi::xml_node node = bounds.child(kNames[i]);
      if (!node) return {};
      const std::string text = text_of(node);
      if (!trimmed(text).empty() && !parse_whole(text, values[i]))
        return damaged(std::string(kNames[i]) + " is " + shown(text) + ", which is no integer");
    }
    scan_.index_bounds = E57IndexBounds{values[0], values[1], values[2], values[3]};
    return {};
  }

  Result<std::optional<E57Limits>> limits(const pugi::xml_node& parent, const std::string& low,
                                          const std::string& high) const {
    if (!parent.child(low.c_str()) || !parent.child(high.c_str()))
      return std::optional<E57Limits>();
    const auto values = numbers<2>(parent, {low.c_str(), high.c_str()});
    if (!values) return values.error();
    return std::optional(E57Limits{(*values)[0], (*values)[1]});
  }

  Result<void> read_limits() {
    constexpr std::array<const char*, 3> kColours{"colorRed", "colorGreen", "colorBlue"};
    for (std::size_t i = 0; i < kColours.size(); ++i) {
      const std::string name = kColours[i];
      auto found = limits(node_.child("colorLimits"), name + "Minimum", name + "Maximum");
      if (!found) return found.error();
      scan_.colour_limits[i] = *found;
    }
    auto found = limits(node_.child("intensityLimits"), "intensityMinimum", "intensityMaximum");
    if (!found) return found.error();
    scan_.intensity_limits = *found;
    return {};
  }

  const pugi::xml_node& node_;
  std::size_t number_;
  std::string prefix_;
  const std::filesystem::path& path_;
  E57Scan scan_;
};

}  // namespace

const E57Field* E57Scan::find(std::string_view field) const {
  for (const E57Field& candidate : fields)
    if (candidate.name == field && candidate.type != E57Field::Type::kText) return &candidate;
  return nullptr;
}

int e57_bits_between(std::int64_t minimum, std::int64_t maximum) {
  const auto range = static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum);
  return static_cast<int>(std::bit_width(range));
}

Result<std::vector<E57Scan>> read_e57_layout(E57Pages& pages) {
  const auto start = pages.logical_offset(pages.xml_offset(), "the XML section");
  if (!start) return start.error();
  const auto text = pages.read(*start, pages.xml_bytes(), "the XML section");
  if (!text) return text.error();
  pugi::xml_document document;
  const auto parsed = document.load_buffer(text->data(), text->size());
  if (!parsed)
    return bad_input(pages.path(), "damaged E57: its XML section breaks off at its byte " +
                                       std::to_string(parsed.offset) + ": " + parsed.description());
  const pugi::xml_node root = document.child("e57Root");
  if (!root) return bad_input(pages.path(), "damaged E57: its XML section has no e57Root");
  std::vector<E57Scan> scans;
  for (const auto& node : root.child("data3D").children()) {
    if (node.type() != pugi::node_element) continue;
    auto scan = E57ScanReader(node, scans.size(), normal_prefix(root), pages.path()).read();
    if (!scan) return scan.error();
    scans.push_back(*std::move(scan));
  }
  return scans;
}

}  // namespace relief
