#include <charconv>

#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

constexpr double kNoIntensity = 0.5;     // What scanner programs write where there is none.
constexpr std::size_t kPointBytes = 60;  // Of text, that memory is reserved for.

// The shortest text that reads back as the same number.
void append_ptx_number(std::string& text, double value) {
  char buffer[40];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

template <typename Values>
void append_ptx_line(std::string& text, const Values& values) {
  for (bool first = true; const double value : values) {
    if (!first) text += ' ';
    append_ptx_number(text, value);
    first = false;
  }
  text += '\n';
}

void append_ptx_header(std::string& text, const RangeView& view, double metres_per_unit) {
  text += std::to_string(view.width()) + "\n" + std::to_string(view.height()) + "\n";
  Eigen::Matrix4d matrix = view.world_from_view.matrix();
  matrix.block<3, 1>(0, 3) *= metres_per_unit;
  append_ptx_line(text, Eigen::Vector3d(matrix.block<3, 1>(0, 3)));
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    append_ptx_line(text, Eigen::Vector3d(matrix.block<3, 1>(0, axis)));
  for (Eigen::Index line = 0; line < 4; ++line)
    append_ptx_line(text, Eigen::Vector4d(matrix.col(line)));
}

// Perceived brightness of a colour, by the weights of Rec. 601.
double brightness(const Colour& colour) {
  return (0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2]) / 255.0;
}

void append_ptx_point(std::string& text, const RangeView& view, int u, int v,
                      double metres_per_unit) {
  const bool sample = view.has_sample(u, v), coloured = !view.colours.empty();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  if (sample) point = view.point(u, v) * metres_per_unit;
  const Colour colour = sample && coloured ? view.colours(u, v) : Colour{};
  for (const double value : point) {
    append_ptx_number(text, value);
    text += ' ';
  }
  append_ptx_number(text, sample && coloured ? brightness(colour) : kNoIntensity);
  if (coloured)
    for (const int level : colour) text += " " + std::to_string(level);
  text += '\n';
}

}  // namespace

std::string encode_ptx(const std::vector<RangeView>& views, double metres_per_unit) {
  std::string text;
  for (const RangeView& view : views) {
    text.reserve(text.size() + kPointBytes * view.range.size());
    append_ptx_header(text, view, metres_per_unit);
    for (int u = 0; u < view.width(); ++u)
      for (int v = view.height() - 1; v >= 0; --v)
        append_ptx_point(text, view, u, v, metres_per_unit);
  }
  return text;
}

Result<void> write_ptx(const std::vector<RangeView>& views, const std::filesystem::path& path,
                       double metres_per_unit) {
  if (views.empty()) return cannot_write(path, "a PTX file holds at least one scan");
  for (const RangeView& view : views)
    if (view.range.empty())
      return cannot_write(path, "view '" + view.name + "' has no grid to write");
  return write_file(path, encode_ptx(views, metres_per_unit));
}

}  // namespace relief
