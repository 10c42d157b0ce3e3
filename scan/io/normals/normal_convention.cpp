#include "scan/io/normals/normal_convention.h"

#include <algorithm>
#include <array>

namespace relief {

namespace {

constexpr int kOtherSpace = 3;

using Order = std::array<int, 3>;  // The axis that each stored component belongs to.

void add_signs(const Order& order, NormalSpace space, std::vector<NormalConvention>& all) {
  for (int signs = 0; signs < 8; ++signs) {
    NormalConvention convention;
    convention.space = space;
    convention.space_from_stored.setZero();
    for (int stored = 0; stored < 3; ++stored)
      convention.space_from_stored(order[static_cast<std::size_t>(stored)], stored) =
          (signs >> stored & 1) != 0 ? -1.0 : 1.0;
    all.push_back(convention);
  }
}

std::vector<NormalConvention> make_conventions(NormalFileKind source) {
  std::vector<NormalConvention> all;
  for (const NormalSpace space : {NormalSpace::kCamera, NormalSpace::kWorld}) {
    for (const Order& order : {Order{0, 1, 2}, Order{1, 0, 2}, Order{2, 1, 0}})
      add_signs(order, space, all);
    if (source == NormalFileKind::kImage && space == NormalSpace::kCamera) continue;
    for (const Order& order : {Order{0, 2, 1}, Order{1, 2, 0}, Order{2, 0, 1}})
      add_signs(order, space, all);
  }
  return all;
}

// The row and sign of the only entry of a column.
std::pair<int, bool> axis_of(const Eigen::Matrix3d& matrix, int stored) {
  Eigen::Index row = 0;
  matrix.col(stored).cwiseAbs().maxCoeff(&row);
  return {static_cast<int>(row), matrix(row, stored) < 0.0};
}

std::string axes_text(const NormalConvention& convention, NormalFileKind source) {
  static constexpr std::array<std::array<const char*, 2>, 3> kCamera = {
      {{"right", "left"}, {"down", "up"}, {"forward", "towards the viewer"}}};
  static constexpr std::array<std::array<const char*, 2>, 3> kFrame = {
      {{"+x", "-x"}, {"+y", "-y"}, {"+z", "-z"}}};
  const bool of_frame = source == NormalFileKind::kGrid || convention.space == NormalSpace::kWorld;
  std::string text;
  for (int stored = 0; stored < 3; ++stored) {
    const auto [axis, reversed] = axis_of(convention.space_from_stored, stored);
    const auto& names = (of_frame ? kFrame : kCamera)[static_cast<std::size_t>(axis)];
    text += std::string(stored > 0 ? ", " : "") + "xyz"[stored] + (of_frame ? " as " : " ") +
            names[reversed ? 1 : 0];
  }
  return text;
}

}  // namespace

NormalConvention named_convention(NormalAxes axes, NormalSpace space) {
  NormalConvention convention;
  convention.space = space;
  if (axes == NormalAxes::kOpengl)
    convention.space_from_stored = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return convention;
}

const std::vector<NormalConvention>& all_conventions(NormalFileKind source) {
  static const std::vector<NormalConvention> image = make_conventions(NormalFileKind::kImage);
  static const std::vector<NormalConvention> grid = make_conventions(NormalFileKind::kGrid);
  return source == NormalFileKind::kImage ? image : grid;
}

int distance(const NormalConvention& a, const NormalConvention& b) {
  int differing = a.space == b.space ? 0 : kOtherSpace;
  for (int stored = 0; stored < 3; ++stored)
    differing += a.space_from_stored.col(stored) != b.space_from_stored.col(stored) ? 1 : 0;
  return differing;
}

std::string to_string(const NormalConvention& convention, NormalFileKind source) {
  const std::string space =
      std::string("space ") + (convention.space == NormalSpace::kCamera ? "camera" : "world");
  if (source == NormalFileKind::kImage)
    for (const auto& [axes, name] :
         {std::pair{NormalAxes::kOpencv, "opencv"}, std::pair{NormalAxes::kOpengl, "opengl"}})
      if (convention == named_convention(axes, convention.space))
        return std::string("axes ") + name + ", " + space;
  if (convention == NormalConvention{}) return "axes of the file";
  return axes_text(convention, source) +
         (source == NormalFileKind::kGrid && convention.space == NormalSpace::kCamera
              ? " of the file"
              : ", " + space);
}

}  // namespace relief
