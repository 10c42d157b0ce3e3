#include "fusion/views/unshared_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "fusion/views/view_difference.h"
#include "scan/base/parallel.h"
#include "scan/views/view_projection.h"

namespace relief::fusion {

namespace {

// Sets samples to `shared` that others measured, or that stand where these saw through.
void mark_measured(const RangeView& view, const ViewSampler& sampler,
                   const std::vector<const ViewSampler*>& others, Grid<std::uint8_t>& shared) {
  parallel_for(static_cast<std::size_t>(view.height()), 1, [&](std::size_t begin, std::size_t end) {
    for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v)
      for (int u = 0; u < view.width(); ++u) {
        if (!view.has_sample(u, v)) continue;
        const Eigen::Vector3d position = view.world_from_view * view.point(u, v);
        const auto own = sampler.observe(position, 0.0);
        // Without a surface of its own a sample is a stray one.
        shared(u, v) = !own || std::ranges::any_of(others, [&](const ViewSampler* other) {
          return difference_from(*other, position, own->normal, 0.0).has_value();
        });
      }
  });
}

// Sets the samples to `shared` whose rays pass what others measured before.
void mark_seen_through(const RangeView& view, const ViewProjection& projection,
                       const ViewSampler& sampler, const std::vector<const ViewSampler*>& others,
                       Grid<std::uint8_t>& shared) {
  const RigidMotion view_from_world = view.world_from_view.inverse();
  for (const ViewSampler* other : others) {
    check_stop_and_memory();
    other->for_surface_points([&](const Eigen::Vector3d& position) {
      const auto seen = sampler.observe(position, 0.0);
      if (!seen || !(seen->distance > other->spacing())) return;
      const Eigen::Vector3d point = view_from_world * position;
      const auto pixel = projection.pixel_of(point);
      if (!pixel) return;
      const double footprint = projection.pixel_footprint(point, pixel->x(), pixel->y());
      // As many pixels as samples of the other view are apart.
      const int reach = static_cast<int>(
          std::ceil(std::min(other->spacing() / footprint, static_cast<double>(view.width()))));
      const Eigen::Vector2i at = pixel->array().round().cast<int>();
      for (int v = std::max(0, at.y() - reach); v <= std::min(view.height() - 1, at.y() + reach);
           ++v)
        for (int u = std::max(0, at.x() - reach); u <= std::min(view.width() - 1, at.x() + reach);
             ++u)
          shared(u, v) = 1;
    });
  }
}

}  // namespace

Result<RangeView> unshared_samples(const RangeView& view, const ViewSampler& sampler,
                                   const std::vector<const ViewSampler*>& others) {
  const auto projection = ViewProjection::create(view);
  if (!projection) return projection.error();
  Grid<std::uint8_t> shared(view.width(), view.height(), 0);
  mark_measured(view, sampler, others, shared);
  mark_seen_through(view, *projection, sampler, others, shared);
  RangeView left = view;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (shared(u, v)) left.range(u, v) = kNoSample;
  return left;
}

}  // namespace relief::fusion
