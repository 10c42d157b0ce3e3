// The one file that meets PCL's readers.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <mutex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <pcl/console/print.h>
#include <pcl/io/lzf.h>
#include <pcl/io/pcd_io.h>

#include "relief/scan/range_view.h"
#include "scan/io/files/io_error.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/grids/grid_view.h"
#include "scan/io/grids/missing_points.h"
#include "scan/io/grids/pcd_header.h"

namespace relief {

namespace {

// PCL reports on the console, by a setting of the whole process: one reader at a time, in silence.
class SilentPcl {
 public:
  SilentPcl() : lock_(mutex()), level_(pcl::console::getVerbosityLevel()) {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  SilentPcl(const SilentPcl&) = delete;
  SilentPcl& operator=(const SilentPcl&) = delete;
  ~SilentPcl() { pcl::console::setVerbosityLevel(level_); }

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::scoped_lock<std::mutex> lock_;
  pcl::console::VERBOSITY_LEVEL level_;
};

// Points as PCL describes them. Their values lie point after point, or field after field as they
// were compressed.
struct PcdCloud {
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  bool by_field = false;

  std::size_t points() const { return std::size_t{cloud.width} * cloud.height; }

  template <typename Value>
  Value value(std::size_t point, const pcl::PCLPointField& field) const {
    const std::size_t start = by_field
                                  ? field.offset * points() + point * sizeof(Value) * field.count
                                  : field.offset + point * cloud.point_step;
    Value value;
    std::memcpy(&value, cloud.data.data() + start, sizeof value);
    return value;
  }
};

// Whether the fields lie one after the other, each as long as its type says.
bool fields_fit(const pcl::PCLPointCloud2& cloud) {
  std::size_t end = 0;
  for (const auto& field : cloud.fields) {
    if (field.offset != end) return false;
    end += std::size_t{field.count} * static_cast<std::size_t>(pcl::getFieldSize(field.datatype));
  }
  return end == cloud.point_step;
}

// The size that read_pcd_header() took for WIDTH 0 and HEIGHT 0, which PCL refuses.
void state_size(const PcdHeader& header, std::string& text) {
  const auto state = [&](const std::string& keyword, std::size_t size) {
    const std::size_t line = text.starts_with(keyword) ? 0 : text.find("\n" + keyword) + 1;
    text.replace(line, text.find('\n', line) - line, keyword + " " + std::to_string(size));
  };
  state("WIDTH", header.width);
  state("HEIGHT", header.height);
}

// PCL knows lines that end in a line feed alone, or behind a return.
std::string with_line_feeds(std::string text) {
  std::ranges::replace(text, '\r', '\n');
  return text;
}

// Whether PCL, which trusts what it reads, reads the header alike. It gets the header alone: it
// would read on in data that begin with a keyword. Makes room for the values.
bool reads_alike(std::ifstream& file, const PcdHeader& header, PcdCloud& to) {
  std::string text(header.data_start, ' ');
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) return false;
  if (header.ends_in_return) text = with_line_feeds(std::move(text));
  if (header.sized_by_points) state_size(header, text);
  std::istringstream stream(text);
  pcl::PCLPointCloud2& cloud = to.cloud;
  int data_type = 0;
  unsigned int data_start = 0;
  return pcl::PCDReader().readHeader(stream, cloud, to.origin, to.orientation, to.version,
                                     data_type, data_start) >= 0 &&
         cloud.width == header.width && cloud.height == header.height &&
         cloud.fields.size() == header.fields && cloud.point_step == header.point_bytes &&
         fields_fit(cloud) && data_type == static_cast<int>(header.data) &&
         data_start == text.size();
}

bool read_bytes(std::ifstream& file, std::vector<std::uint8_t>& bytes) {
  return bool(
      file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
}

// Field by field.
bool unpack(std::ifstream& file, PcdCloud& to) {
  std::array<std::uint32_t, 2> sizes{};  // Compressed and not.
  if (!file.read(reinterpret_cast<char*>(sizes.data()), sizeof sizes)) return false;
  std::vector<std::uint8_t> compressed(sizes[0]);
  std::vector<std::uint8_t>& values = to.cloud.data;
  const auto size = static_cast<unsigned int>(values.size());
  // PCL reads a first byte even where there is none.
  if (sizes[0] == 0 || sizes[1] != values.size() || !read_bytes(file, compressed) ||
      pcl::lzfDecompress(compressed.data(), sizes[0], values.data(), size) != size)
    return false;
  to.by_field = true;
  return true;
}

bool read_ascii(std::ifstream& file, const PcdHeader& header, PcdCloud& to) {
  pcl::PCDReader reader;
  if (!header.ends_in_return) return reader.readBodyASCII(file, to.cloud, to.version) >= 0;
  std::istringstream text(with_line_feeds(std::string(std::istreambuf_iterator<char>(file), {})));
  return reader.readBodyASCII(text, to.cloud, to.version) >= 0;
}

// PCL's own way copies binary values twice more, which takes as long as reading them.
bool read_values(std::ifstream& file, const PcdHeader& header, PcdCloud& to) {
  to.cloud.data.resize(header.points * header.point_bytes);
  switch (header.data) {
    case PcdHeader::Data::kAscii:
      return read_ascii(file, header, to);
    case PcdHeader::Data::kBinary:
      return read_bytes(file, to.cloud.data);
    case PcdHeader::Data::kCompressed:
      return unpack(file, to);
  }
  return false;
}

const pcl::PCLPointField* find_field(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const auto& field : cloud.fields) {
    const bool real = field.datatype == pcl::PCLPointField::FLOAT32 ||
                      field.datatype == pcl::PCLPointField::FLOAT64;
    if (field.name == name && real) return &field;
  }
  return nullptr;
}

double value_at(const PcdCloud& cloud, std::size_t point, const pcl::PCLPointField& field) {
  return field.datatype == pcl::PCLPointField::FLOAT64 ? cloud.value<double>(point, field)
                                                       : cloud.value<float>(point, field);
}

// PCL packs colours into the bits of a float or of an integer.
const pcl::PCLPointField* find_colour(const pcl::PCLPointCloud2& cloud) {
  for (const auto& field : cloud.fields)
    if ((field.name == "rgb" || field.name == "rgba") &&
        (field.datatype == pcl::PCLPointField::FLOAT32 ||
         field.datatype == pcl::PCLPointField::UINT32 ||
         field.datatype == pcl::PCLPointField::INT32))
      return &field;
  return nullptr;
}

Colour colour_at(const PcdCloud& cloud, std::size_t point, const pcl::PCLPointField& field) {
  const auto packed = cloud.value<std::uint32_t>(point, field);
  return {static_cast<std::uint8_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8),
          static_cast<std::uint8_t>(packed)};
}

struct VectorField {
  const pcl::PCLPointField *x, *y, *z;
  bool complete() const { return x && y && z; }
  Eigen::Vector3d at(const PcdCloud& cloud, std::size_t point) const {
    return {value_at(cloud, point, *x), value_at(cloud, point, *y), value_at(cloud, point, *z)};
  }
};

Result<GridFile> grid_from_cloud(const PcdCloud& from, const std::filesystem::path& path) {
  const pcl::PCLPointCloud2& cloud = from.cloud;
  const VectorField position{find_field(cloud, "x"), find_field(cloud, "y"),
                             find_field(cloud, "z")};
  if (!position.complete()) return bad_input(path, "the PCD has no real fields x, y and z");
  const VectorField normal{find_field(cloud, "normal_x"), find_field(cloud, "normal_y"),
                           find_field(cloud, "normal_z")};
  const pcl::PCLPointField* confidence = find_field(cloud, "confidence");
  const pcl::PCLPointField* colour = find_colour(cloud);
  const int width = static_cast<int>(cloud.width), height = static_cast<int>(cloud.height);
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(width, height, Eigen::Vector3d::Constant(kNoSample));
  if (cloud.data.size() < grid.points.size() * cloud.point_step)
    return bad_input(path, "truncated PCD");
  const Eigen::Vector3f no_normal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
  if (normal.complete()) grid.normals = Grid<Eigen::Vector3f>(width, height, no_normal);
  if (confidence) grid.confidence = Grid<float>(width, height, 0.0f);
  if (colour) grid.colours = Grid<Colour>(width, height, Colour{});
  for (std::size_t i = 0; i < grid.points.size(); ++i) {
    const Eigen::Vector3d point = position.at(from, i);
    if (!point.allFinite()) continue;
    grid.points[i] = point;
    if (normal.complete()) grid.normals[i] = normal.at(from, i).cast<float>();
    if (confidence) grid.confidence[i] = static_cast<float>(value_at(from, i, *confidence));
    if (colour) grid.colours[i] = colour_at(from, i, *colour);
  }
  auto missing = invalidate_missing_points({grid.points.begin(), grid.points.end()});
  grid.missing_at_origin = missing.at_origin;
  grid.notes = std::move(missing.notes);
  return grid;
}

Result<GridFile> read_pcd(const std::filesystem::path& path, bool organized) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return bad_input(path, "no such file");
  const auto header = read_pcd_header(path, organized);
  if (!header) return header.error();
  const SilentPcl silence;
  try {
    PcdCloud cloud;
    std::ifstream file(path, std::ios::binary);
    if (!reads_alike(file, *header, cloud)) return bad_input(path, "damaged PCD header");
    if (!read_values(file, *header, cloud)) return bad_input(path, "damaged or truncated PCD");
    const auto pose = pose_from_viewpoint(cloud.origin.head<3>(), cloud.orientation);
    if (!pose) return bad_input(path, "VIEWPOINT: " + pose.error().message);
    auto grid = grid_from_cloud(cloud, path);
    if (grid) grid->world_from_view = *pose;
    return grid;
  } catch (const std::exception& exception) {
    return bad_input(path, std::string("damaged PCD: ") + exception.what());
  }
}

}  // namespace

Result<GridFile> read_pcd_grid(const std::filesystem::path& path) { return read_pcd(path, true); }

Result<GridFile> read_pcd_points(const std::filesystem::path& path) {
  return read_pcd(path, false);
}

}  // namespace relief
