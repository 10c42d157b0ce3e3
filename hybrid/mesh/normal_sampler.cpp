#include "hybrid/mesh/normal_sampler.h"

#include <cmath>
#include <utility>

#include "relief/scan/discontinuities.h"
#include "scan/base/parallel.h"
#include "scan/base/usable_pose.h"
#include "scan/grid/connected_grid.h"
#include "scan/surface/observation_weights.h"

namespace relief::hybrid {

namespace {

// A view whose surface turns further from the vertex's normal sees something else.
constexpr double kLeastAgreement = 0.25;  // cosine, 76 degrees
constexpr double kLeastCosine = 0.1;      // of the viewing angle, 84 degrees
// How far from the vertex a patch may be, and the first corner of its quad [largest distances].
// The second is beyond all quads that may tell a normal, and bounds the time.
constexpr double kPatch = 2.0, kFar = 10.0;

}  // namespace

NormalSampler::NormalSampler(const RangeView& view, ViewProjection projection, int silhouette_ramp)
    : projection_(std::move(projection)), view_from_world_(view.world_from_view.inverse()) {
  const ConnectedGrid grid = connect_grid(view);
  const ObservationWeightOptions weights{.silhouette_ramp = silhouette_ramp};
  surface_ = RangeSurface(view, grid, view.normals,
                          observation_weights(view, grid, view.normals, weights));
  surface_.for_each_sample(
      [&](int u, int v) { bounds_.extend(view.world_from_view * surface_.point(u, v)); });
}

std::optional<NormalObservation> NormalSampler::at(const Eigen::Vector3d& vertex,
                                                   const Eigen::Vector3d& mesh_normal,
                                                   double max_distance) const {
  const Eigen::Vector3d point = view_from_world_ * vertex;
  const auto pixel = projection_.pixel_of(point);
  const auto quad = pixel ? surface_.quad_at(*pixel) : std::nullopt;
  if (!quad) return std::nullopt;
  // Most views see something else there: of these nothing more is looked up.
  if (!((point - surface_.point(quad->u, quad->v)).norm() < kFar * max_distance))
    return std::nullopt;
  const auto patch = surface_.patch(*quad);
  if (!patch || !((point - patch->point()).norm() < kPatch * max_distance)) return std::nullopt;
  const RangeView& view = surface_.view();
  const Eigen::Vector3d ray = view.camera.ray(quad->u, quad->v).direction.normalized();
  const Eigen::Vector3d normal = view.world_from_view.linear() * patch->normal;
  const bool sees = -patch->normal.dot(ray) > kLeastCosine &&
                    normal.dot(mesh_normal) > kLeastAgreement &&
                    std::abs(patch->distance(point)) < max_distance && patch->weight > 0.0;
  return sees ? std::optional(NormalObservation{normal, patch->weight}) : std::nullopt;
}

// Patches bulge beyond their samples, by less than the one more distance.
bool NormalSampler::concerns(const Eigen::AlignedBox3d& box, double max_distance) const {
  return !bounds_.isEmpty() && bounds_.exteriorDistance(box) < (kPatch + 1.0) * max_distance;
}

Result<std::vector<NormalSampler>> normal_samplers(const std::vector<RangeView>& views,
                                                   int silhouette_ramp) {
  std::vector<const RangeView*> used;
  for (const RangeView& view : views)
    if (view.has_normals() && has_usable_pose(view, views.size()) && view.sample_count() > 0)
      used.push_back(&view);
  using Prepared = std::optional<Result<NormalSampler>>;
  auto prepared = parallel_map<Prepared>(used.size(), [&](std::size_t i) -> Prepared {
    auto projection = ViewProjection::create(*used[i]);
    if (!projection) return projection.error();
    return NormalSampler(*used[i], std::move(projection).value(), silhouette_ramp);
  });
  std::vector<NormalSampler> samplers;
  for (auto& sampler : prepared) {
    if (!*sampler) return sampler->error();
    samplers.push_back(std::move(*sampler).value());
  }
  return samplers;
}

NearViews views_near(const Eigen::AlignedBox3d& box, const std::vector<NormalSampler>& samplers,
                     double max_distance) {
  NearViews near;
  for (std::size_t i = 0; i < samplers.size(); ++i)
    if (samplers[i].concerns(box, max_distance)) near.push_back(i);
  return near;
}

}  // namespace relief::hybrid
