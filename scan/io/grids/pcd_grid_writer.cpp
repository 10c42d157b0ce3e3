// PCL's own writer rounds the VIEWPOINT to six digits and needs a file of its own.
#include "scan/io/grids/pcd_grid_writer.h"

#include <charconv>
#include <limits>

#include <Eigen/Geometry>

#include "scan/io/files/binary_writer.h"

namespace relief {

namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// The fields of 4 bytes each that the view needs.
std::string fields_of(const RangeView& view) {
  std::string fields = " x y z";
  if (view.has_normals()) fields += " normal_x normal_y normal_z";
  if (!view.confidence.empty()) fields += " confidence";
  if (!view.colours.empty()) fields += " rgb";
  return fields;
}

std::string repeated(const std::string& word, const std::string& fields) {
  std::string text;
  for (const char c : fields)
    if (c == ' ') text += " " + word;
  return text;
}

// The shortest text that reads back as the same number.
std::string number_text(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string viewpoint(const RigidMotion& world_from_view) {
  const Eigen::Vector3d origin = world_from_view.translation();
  const Eigen::Quaterniond q(world_from_view.linear());
  std::string text;
  for (const double value : {origin.x(), origin.y(), origin.z(), q.w(), q.x(), q.y(), q.z()})
    text += " " + number_text(value);
  return text;
}

std::string header(const RangeView& view) {
  const std::string fields = fields_of(view);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" + fields + "\nSIZE" +
         repeated("4", fields) + "\nTYPE" + repeated("F", fields) + "\nCOUNT" +
         repeated("1", fields) + "\nWIDTH " + std::to_string(view.width()) + "\nHEIGHT " +
         std::to_string(view.height()) + "\nVIEWPOINT" + viewpoint(view.world_from_view) +
         "\nPOINTS " + std::to_string(view.range.size()) + "\nDATA binary\n";
}

void append_vector(std::string& bytes, const Eigen::Vector3f& vector) {
  for (const float value : vector) append_little_endian(bytes, value);
}

// The bits of the field `rgb`, which is a float by name only.
std::uint32_t packed(const Colour& colour) {
  return std::uint32_t{colour[0]} << 16 | std::uint32_t{colour[1]} << 8 | std::uint32_t{colour[2]};
}

}  // namespace

std::string encode_pcd_grid(const RangeView& view) {
  const Eigen::Vector3f none = Eigen::Vector3f::Constant(kNone);
  std::string bytes = header(view);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const bool sample = view.has_sample(u, v);
      append_vector(bytes, sample ? view.point(u, v).cast<float>() : none);
      if (view.has_normals())
        append_vector(bytes, sample ? Eigen::Vector3f(view.normals(u, v)) : none);
      if (!view.confidence.empty())
        append_little_endian(bytes, sample ? view.confidence(u, v) : 0.0f);
      if (!view.colours.empty())
        append_little_endian(bytes, sample ? packed(view.colours(u, v)) : 0u);
    }
  }
  return bytes;
}

}  // namespace relief
