#include "relief/interop/pcl_conversion.h"

#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include <pcl/common/io.h>

#include "scan/io/grids/grid_view.h"

namespace relief::interop {

namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

template <typename Point>
constexpr bool kHasColour = std::is_same_v<Point, pcl::PointXYZRGBNormal>;

template <typename Point>
void set_colour(Point& point, const RangeView& view, int u, int v) {
  point.r = point.g = point.b = 0;
  if (view.colours.empty() || !view.has_sample(u, v)) return;
  const Colour& colour = view.colours(u, v);
  point.r = colour[0];
  point.g = colour[1];
  point.b = colour[2];
}

template <typename Point>
Point point_at(const RangeView& view, int u, int v) {
  Point point;
  point.getVector3fMap().setConstant(kNone);
  point.getNormalVector3fMap().setConstant(kNone);
  if (view.has_sample(u, v)) {
    point.getVector3fMap() = view.point(u, v).template cast<float>();
    if (view.has_normals()) point.getNormalVector3fMap() = view.normals(u, v);
  }
  if constexpr (kHasColour<Point>) set_colour(point, view, u, v);
  return point;
}

template <typename Point>
Result<GridFile> grid_of(const pcl::PointCloud<Point>& cloud) {
  const auto pose =
      pose_from_viewpoint(cloud.sensor_origin_.template head<3>(), cloud.sensor_orientation_);
  if (!pose) return pose.error();
  const int width = static_cast<int>(cloud.width), height = static_cast<int>(cloud.height);
  if (cloud.size() != std::size_t{cloud.width} * cloud.height)
    return Error{ErrorKind::kBadInput,
                 "the cloud has " + std::to_string(cloud.size()) + " points, not width x height"};
  GridFile grid;
  grid.world_from_view = *pose;
  grid.points = Grid<Eigen::Vector3d>(width, height, Eigen::Vector3d::Constant(kNoSample));
  grid.normals = Grid<Eigen::Vector3f>(width, height, Eigen::Vector3f::Constant(kNone));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    grid.normals[i] = cloud[i].getNormalVector3fMap();
    if (cloud[i].getVector3fMap().allFinite())
      grid.points[i] = cloud[i].getVector3fMap().template cast<double>();
  }
  return grid;
}

// Empty when all are black.
Grid<Colour> colours_of(const pcl::PointCloud<pcl::PointXYZRGBNormal>& cloud) {
  Grid<Colour> colours(static_cast<int>(cloud.width), static_cast<int>(cloud.height));
  bool any = false;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    colours[i] = {cloud[i].r, cloud[i].g, cloud[i].b};
    any |= colours[i] != Colour{};
  }
  return any ? colours : Grid<Colour>();
}

// No normals at all are different from normals that are unknown.
void drop_absent_normals(RangeView& view) {
  for (const Eigen::Vector3f& normal : view.normals)
    if (normal.allFinite()) return;
  view.normals = {};
}

template <typename Point>
Result<RangeView> view_of(const pcl::PointCloud<Point>& cloud,
                          const std::optional<Camera>& camera) {
  auto grid = grid_of(cloud);
  if (!grid) return grid.error();
  if constexpr (kHasColour<Point>) grid->colours = colours_of(cloud);
  auto view = view_from_grid(*grid, camera);
  if (view) drop_absent_normals(*view);
  return view;
}

using Field = pcl::PCLPointField;

std::size_t size_of(std::uint8_t datatype) {
  return static_cast<std::size_t>(pcl::getFieldSize(datatype));
}

void add_field(pcl::PCLPointCloud2& cloud, const std::string& name, std::uint8_t datatype) {
  Field field;
  field.name = name;
  field.offset = cloud.point_step;
  field.datatype = datatype;
  field.count = 1;
  cloud.fields.push_back(field);
  cloud.point_step += static_cast<pcl::uindex_t>(size_of(datatype));
}

void add_fields(pcl::PCLPointCloud2& cloud, const TriangleMesh& mesh) {
  for (const char* name : {"x", "y", "z"}) add_field(cloud, name, Field::FLOAT32);
  if (!mesh.normals.empty())
    for (const char* name : {"normal_x", "normal_y", "normal_z"})
      add_field(cloud, name, Field::FLOAT32);
  if (!mesh.quality.empty()) add_field(cloud, "quality", Field::FLOAT32);
  if (!mesh.views.empty()) add_field(cloud, "views", Field::UINT16);
  if (!mesh.source_views.empty()) add_field(cloud, "source_view", Field::UINT16);
  if (!mesh.filled.empty()) add_field(cloud, "filled", Field::UINT8);
  if (!mesh.colours.empty()) add_field(cloud, "rgb", Field::FLOAT32);
}

std::uint32_t packed(const Colour& colour) {
  return std::uint32_t{colour[0]} << 16 | std::uint32_t{colour[1]} << 8 | std::uint32_t{colour[2]};
}

// Writes values one behind the other.
class Packer {
 public:
  explicit Packer(std::uint8_t* at) : at_(at) {}
  template <typename T>
  void put(const T& value) {
    std::memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }

 private:
  std::uint8_t* at_;
};

// In the order of add_fields.
void pack_vertex(const TriangleMesh& mesh, std::size_t i, Packer packer) {
  for (const double value : mesh.vertices[i]) packer.put(static_cast<float>(value));
  if (!mesh.normals.empty())
    for (const float value : mesh.normals[i]) packer.put(value);
  if (!mesh.quality.empty()) packer.put(mesh.quality[i]);
  if (!mesh.views.empty()) packer.put(mesh.views[i]);
  if (!mesh.source_views.empty()) packer.put(mesh.source_views[i]);
  if (!mesh.filled.empty()) packer.put(mesh.filled[i]);
  if (!mesh.colours.empty()) packer.put(packed(mesh.colours[i]));
}

// A field of the cloud that has one of the given types; null when there is none.
const Field* find_field(const pcl::PCLPointCloud2& cloud, const std::string& name,
                        std::initializer_list<std::uint8_t> datatypes) {
  for (const Field& field : cloud.fields)
    if (field.name == name)
      for (const std::uint8_t datatype : datatypes)
        if (field.datatype == datatype &&
            field.offset + size_of(datatype) <= std::size_t{cloud.point_step})
          return &field;
  return nullptr;
}

template <typename T>
T value_at(const pcl::PCLPointCloud2& cloud, std::size_t point, const Field& field) {
  T value;
  std::memcpy(&value, cloud.data.data() + point * cloud.point_step + field.offset, sizeof value);
  return value;
}

double real_at(const pcl::PCLPointCloud2& cloud, std::size_t point, const Field& field) {
  return field.datatype == Field::FLOAT64
             ? value_at<double>(cloud, point, field)
             : static_cast<double>(value_at<float>(cloud, point, field));
}

// Three real fields; nothing unless the cloud has them all.
std::optional<std::array<const Field*, 3>> find_vector(const pcl::PCLPointCloud2& cloud,
                                                       const std::array<const char*, 3>& names) {
  std::array<const Field*, 3> fields;
  for (std::size_t k = 0; k < 3; ++k) {
    fields[k] = find_field(cloud, names[k], {Field::FLOAT32, Field::FLOAT64});
    if (!fields[k]) return std::nullopt;
  }
  return fields;
}

Eigen::Vector3d vector_at(const pcl::PCLPointCloud2& cloud, std::size_t point,
                          const std::array<const Field*, 3>& fields) {
  return {real_at(cloud, point, *fields[0]), real_at(cloud, point, *fields[1]),
          real_at(cloud, point, *fields[2])};
}

Colour unpacked(std::uint32_t bits) {
  return {static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 8),
          static_cast<std::uint8_t>(bits)};
}

Result<void> read_vertices(const pcl::PCLPointCloud2& cloud, std::size_t count,
                           TriangleMesh& mesh) {
  const auto position = find_vector(cloud, {"x", "y", "z"});
  if (!position) return Error{ErrorKind::kBadInput, "the cloud has no real fields x, y and z"};
  for (std::size_t i = 0; i < count; ++i) {
    mesh.vertices.push_back(vector_at(cloud, i, *position));
    if (!mesh.vertices.back().allFinite())
      return Error{ErrorKind::kBadInput, "vertex " + std::to_string(i) + " is not finite"};
  }
  return {};
}

void read_attributes(const pcl::PCLPointCloud2& cloud, std::size_t count, TriangleMesh& mesh) {
  const auto normal = find_vector(cloud, {"normal_x", "normal_y", "normal_z"});
  const Field* quality = find_field(cloud, "quality", {Field::FLOAT32});
  const Field* views = find_field(cloud, "views", {Field::UINT16});
  const Field* sources = find_field(cloud, "source_view", {Field::UINT16});
  const Field* filled = find_field(cloud, "filled", {Field::UINT8});
  const Field* rgb = find_field(cloud, "rgb", {Field::FLOAT32, Field::UINT32});
  if (!rgb) rgb = find_field(cloud, "rgba", {Field::UINT32});
  for (std::size_t i = 0; i < count; ++i) {
    if (normal) mesh.normals.push_back(vector_at(cloud, i, *normal).cast<float>());
    if (quality) mesh.quality.push_back(value_at<float>(cloud, i, *quality));
    if (views) mesh.views.push_back(value_at<std::uint16_t>(cloud, i, *views));
    if (sources) mesh.source_views.push_back(value_at<std::uint16_t>(cloud, i, *sources));
    if (filled) mesh.filled.push_back(value_at<std::uint8_t>(cloud, i, *filled));
    if (rgb) mesh.colours.push_back(unpacked(value_at<std::uint32_t>(cloud, i, *rgb)));
  }
}

Result<void> read_polygon(const pcl::Vertices& polygon, std::size_t index, TriangleMesh& mesh) {
  const auto& corners = polygon.vertices;
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, "polygon " + std::to_string(index) + ": " + what};
  };
  if (corners.size() < 3) return wrong(std::to_string(corners.size()) + " corners");
  for (const auto corner : corners)
    if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.vertices.size())
      return wrong("vertex index " + std::to_string(corner) + " of " +
                   std::to_string(mesh.vertices.size()));
  for (std::size_t k = 2; k < corners.size(); ++k)
    mesh.faces.push_back({static_cast<std::uint32_t>(corners[0]),
                          static_cast<std::uint32_t>(corners[k - 1]),
                          static_cast<std::uint32_t>(corners[k])});
  return {};
}

}  // namespace

template <typename Point>
pcl::PointCloud<Point> to_pcl(const RangeView& view) {
  pcl::PointCloud<Point> cloud(static_cast<std::uint32_t>(view.width()),
                               static_cast<std::uint32_t>(view.height()));
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      cloud[view.range.index(u, v)] = point_at<Point>(view, u, v);
  cloud.is_dense = view.sample_count() == view.range.size();
  cloud.sensor_origin_ << view.world_from_view.translation().cast<float>(), 0.0f;
  cloud.sensor_orientation_ = Eigen::Quaterniond(view.world_from_view.linear()).cast<float>();
  return cloud;
}

template pcl::PointCloud<pcl::PointNormal> to_pcl(const RangeView& view);
template pcl::PointCloud<pcl::PointXYZRGBNormal> to_pcl(const RangeView& view);

Result<RangeView> from_pcl(const pcl::PointCloud<pcl::PointNormal>& cloud,
                           const std::optional<Camera>& camera) {
  return view_of(cloud, camera);
}

Result<RangeView> from_pcl(const pcl::PointCloud<pcl::PointXYZRGBNormal>& cloud,
                           const std::optional<Camera>& camera) {
  return view_of(cloud, camera);
}

pcl::PolygonMesh to_pcl(const TriangleMesh& mesh) {
  pcl::PolygonMesh result;
  pcl::PCLPointCloud2& cloud = result.cloud;
  add_fields(cloud, mesh);
  cloud.width = static_cast<pcl::uindex_t>(mesh.vertices.size());
  cloud.height = 1;
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.is_dense = 1;
  cloud.data.resize(mesh.vertices.size() * cloud.point_step);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    pack_vertex(mesh, i, Packer(cloud.data.data() + i * cloud.point_step));
  result.polygons.resize(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (const std::uint32_t vertex : mesh.faces[f])
      result.polygons[f].vertices.push_back(static_cast<pcl::index_t>(vertex));
  return result;
}

Result<TriangleMesh> from_pcl(const pcl::PolygonMesh& mesh) {
  const pcl::PCLPointCloud2& cloud = mesh.cloud;
  const std::size_t count = std::size_t{cloud.width} * cloud.height;
  if (cloud.point_step > 0 && cloud.data.size() / cloud.point_step < count)
    return Error{ErrorKind::kBadInput, "the cloud holds less data than points"};
  TriangleMesh result;
  if (auto read = read_vertices(cloud, count, result); !read) return read.error();
  read_attributes(cloud, count, result);
  for (std::size_t f = 0; f < mesh.polygons.size(); ++f)
    if (auto read = read_polygon(mesh.polygons[f], f, result); !read) return read.error();
  return result;
}

}  // namespace relief::interop
