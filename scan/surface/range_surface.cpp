#include "scan/surface/range_surface.h"

#include <limits>
#include <utility>

namespace relief {

RangeSurface::RangeSurface(const RangeView& view, const ConnectedGrid& grid,
                           const Grid<Eigen::Vector3f>& normals, Grid<float> weights)
    : view_(&view),
      weights_(std::move(weights)),
      spacing_(sample_spacing(grid.points, grid.edges)) {
  Grid<Eigen::Vector3f> weighted = normals;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (!view.has_sample(u, v) || !(weight(u, v) > 0.0))
        weighted(u, v).setConstant(std::numeric_limits<float>::quiet_NaN());
  normals_ = PackedNormals(weighted);
  normals_.for_each([&](int u, int v, PackedNormal& normal) {
    normal.note = grid.boundary(u, v);
    if (grid.edges.connected_quad(u, v) && has_sample(u + 1, v) && has_sample(u, v + 1) &&
        has_sample(u + 1, v + 1))
      normal.note |= kQuad;
  });
}

std::optional<SurfaceQuad> RangeSurface::quad_at(const Eigen::Vector2d& pixel,
                                                 int least_boundary_distance) const {
  const auto quad = SurfaceQuad::at(pixel, width(), height());
  if (!quad || !has_quad(quad->u, quad->v)) return std::nullopt;
  for (int k = 0; k < 4 && least_boundary_distance > 0; ++k)
    if (!reaches(normals_(quad->u + (k & 1), quad->v + (k >> 1)), least_boundary_distance))
      return std::nullopt;
  return quad;
}

std::optional<SurfacePatch> RangeSurface::patch(const SurfaceQuad& quad) const {
  SurfacePatch patch;
  patch.origin = point(quad.u, quad.v);
  for (int k = 0; k < 4; ++k) {
    const int u = quad.u + (k & 1), v = quad.v + (k >> 1);
    const double share = quad.shares[static_cast<std::size_t>(k)];
    const Eigen::Vector3d corner = point(u, v) - patch.origin;
    const Eigen::Vector3d normal = share / PackedNormal::kUnit * normals_(u, v).scaled();
    patch.chord += share * corner;
    patch.normal += normal;
    patch.tangent_offset += normal.dot(corner);
    patch.weight += share * weight(u, v);
  }
  if (!patch.normalize()) return std::nullopt;
  return patch;
}

}  // namespace relief
