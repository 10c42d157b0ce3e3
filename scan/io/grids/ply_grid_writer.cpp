#include "scan/io/grids/ply_grid_writer.h"

#include "scan/io/files/binary_writer.h"

namespace relief {

namespace {

std::string header(const RangeView& view, std::size_t samples) {
  std::string text = "ply\nformat binary_little_endian 1.0\nobj_info num_cols " +
                     std::to_string(view.width()) + "\nobj_info num_rows " +
                     std::to_string(view.height()) + "\nelement vertex " + std::to_string(samples) +
                     "\nproperty double x\nproperty double y\nproperty double z\n";
  if (view.has_normals()) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!view.confidence.empty()) text += "property float confidence\n";
  if (!view.colours.empty())
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  return text + "element range_grid " + std::to_string(view.range.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

std::string encode_ply_grid(const RangeView& view) {
  std::string bytes = header(view, view.sample_count());
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      for (const double value : view.point(u, v)) append_little_endian(bytes, value);
      if (view.has_normals())
        for (const float value : view.normals(u, v)) append_little_endian(bytes, value);
      if (!view.confidence.empty()) append_little_endian(bytes, view.confidence(u, v));
      if (!view.colours.empty())
        for (const std::uint8_t value : view.colours(u, v)) append_little_endian(bytes, value);
    }
  }
  std::int32_t next = 0;
  for (const double t : view.range) {
    const bool sample = t == t;
    append_little_endian(bytes, static_cast<std::uint8_t>(sample));
    if (sample) append_little_endian(bytes, next++);
  }
  return bytes;
}

}  // namespace relief
