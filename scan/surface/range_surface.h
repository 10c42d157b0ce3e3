#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"
#include "scan/surface/packed_normals.h"
#include "scan/surface/surface_patch.h"

namespace relief {

/// The surface that a view measured: samples with normals, joined into quads along connected grid
/// edges. No quad spans an occlusion edge. Alignment, merging and blending of normals prepare it
/// from their own normals and weights, and put on it what they need besides. View frame.
class RangeSurface {
 public:
  RangeSurface() = default;
  /// The surface of the samples that have a normal in `normals` and a positive weight. `weights`
  /// empty: the view's confidences. `grid` is that of the view. The view outlives the surface with
  /// its ranges, and confidences where they are taken, unchanged.
  RangeSurface(const RangeView& view, const ConnectedGrid& grid,
               const Grid<Eigen::Vector3f>& normals, Grid<float> weights = {});
  RangeSurface(const RangeView&& view, const ConnectedGrid& grid,
               const Grid<Eigen::Vector3f>& normals, Grid<float> weights = {}) = delete;

  const RangeView& view() const { return *view_; }
  int width() const { return normals_.width(); }
  int height() const { return normals_.height(); }
  double spacing() const { return spacing_; }  ///< Median distance of connected samples [unit].

  /// Whether the surface has a sample at (u,v), and at least so far from boundaries [pixels].
  bool has_sample(int u, int v, int least_boundary_distance = 0) const {
    return normals_.holds(u, v, u, v) && reaches(normals_(u, v), least_boundary_distance);
  }
  /// Whether (u,v), (u+1,v), (u,v+1) and (u+1,v+1) are samples of one surface.
  bool has_quad(int u, int v) const {
    return normals_.holds(u, v, u + 1, v + 1) && (normals_(u, v).note & kQuad) != 0;
  }

  /// The sample at (u,v), which the surface has.
  Eigen::Vector3d point(int u, int v) const { return view_->point(u, v); }
  Eigen::Vector3d normal(int u, int v) const { return normals_(u, v).scaled().normalized(); }
  double weight(int u, int v) const {
    return weights_.empty() ? view_->confidence_at(u, v) : weights_(u, v);
  }
  /// See boundary_distance() of discontinuities.h [pixels].
  int boundary_distance(int u, int v) const { return normals_(u, v).note & kBoundaryDistance; }

  /// Calls visit(u, v) for all samples, row by row.
  template <typename Visit>
  void for_each_sample(const Visit& visit) const {
    normals_.for_each([&](int u, int v, const PackedNormal&) { visit(u, v); });
  }

  /// The quad round a pixel. Nothing where there is none, or where a corner is nearer than this to
  /// a boundary [pixels].
  std::optional<SurfaceQuad> quad_at(const Eigen::Vector2d& pixel,
                                     int least_boundary_distance = 0) const;
  /// The surface in a quad. Nothing where the normals of its corners have no mean.
  std::optional<SurfacePatch> patch(const SurfaceQuad& quad) const;

 private:
  // The note of a normal.
  static constexpr unsigned kBoundaryDistance = 0xff, kQuad = 0x100;

  static bool reaches(const PackedNormal& normal, int least_boundary_distance) {
    return normal.exists() &&
           static_cast<int>(normal.note & kBoundaryDistance) >= least_boundary_distance;
  }

  const RangeView* view_ = nullptr;
  PackedNormals normals_;
  Grid<float> weights_;  // Empty: the view's confidences.
  double spacing_ = 0.0;
};

}  // namespace relief
