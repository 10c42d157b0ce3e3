#include "scan/surface/packed_normals.h"

#include <algorithm>

namespace relief {

PackedNormals::PackedNormals(const Grid<Eigen::Vector3f>& normals)
    : width_(normals.width()), height_(normals.height()) {
  int left = width_, right = 0, top = height_, bottom = 0;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      if (!normals(u, v).allFinite()) continue;
      left = std::min(left, u);
      right = std::max(right, u + 1);
      top = std::min(top, v);
      bottom = v + 1;
    }
  }
  if (right <= left) return;
  left_ = left;
  top_ = top;
  stored_ = Grid<PackedNormal>(right - left, bottom - top);
  for (int v = top; v < bottom; ++v)
    for (int u = left; u < right; ++u)
      if (normals(u, v).allFinite()) (*this)(u, v) = PackedNormal(normals(u, v));
}

}  // namespace relief
