#include "scan/units/input_hash.h"

#include "scan/base/parallel.h"

namespace relief {

void hash_into(ContentHash& hash, const Ray& ray) {
  const auto& [origin, direction] = ray;
  hash.add(origin, direction);
}

void hash_into(ContentHash& hash, const PinholeIntrinsics& intrinsics) {
  const auto& [fx, fy, cx, cy] = intrinsics;
  hash.add(fx, fy, cx, cy);
}

void hash_into(ContentHash& hash, const RationalProjection& projection) {
  const auto& [u_numerator, u_denominator, v_numerator, v_denominator] = projection;
  hash.add(u_numerator, u_denominator, v_numerator, v_denominator);
}

void hash_into(ContentHash& hash, const SphericalProjection& projection) {
  const auto& [azimuth, elevation] = projection;
  hash.add(azimuth, elevation);
}

namespace {

// Steps from pixel to pixel are read far outside the grid, where every bit of them tells.
void add_orthographic(const Camera& camera, ContentHash& hash) {
  // [pixels]; a power of two, so that steps are not rounded, beyond the 53 bits of a double.
  constexpr double kFar = 0x1p60;
  hash.add(camera.ray_at(0.0, 0.0), camera.ray_at(kFar, 0.0), camera.ray_at(0.0, kFar));
}

// Row by row: a call for each ray would take longer than its hash.
void add_table(const Camera& camera, ContentHash& hash) {
  std::vector<Eigen::Vector3d> row(2 * static_cast<std::size_t>(camera.width()));
  for (int v = 0; v < camera.height(); ++v) {
    for (int u = 0; u < camera.width(); ++u) {
      const Ray ray = camera.ray(u, v);
      row[2 * static_cast<std::size_t>(u)] = ray.origin;
      row[2 * static_cast<std::size_t>(u) + 1] = ray.direction;
    }
    hash.add(row);
  }
  hash.add(camera.projection());
}

}  // namespace

void hash_into(ContentHash& hash, const Camera& camera) {
  hash.add(camera.model(), camera.width(), camera.height(), camera.intrinsics());
  const SphericalProjection* spherical = camera.spherical_projection();
  hash.add(spherical != nullptr);
  if (spherical != nullptr) hash.add(*spherical);
  if (camera.model() == Camera::Model::kOrthographic) add_orthographic(camera, hash);
  if (camera.model() == Camera::Model::kRayTable) add_table(camera, hash);
}

void hash_into(ContentHash& hash, const TriangleMesh& mesh) {
  const auto& [vertices, faces, normals, quality, views, source_views, filled, colours] = mesh;
  hash.add(vertices, faces, normals, quality, views, source_views, filled, colours);
}

void hash_into(ContentHash& hash, const DiscontinuityOptions& options) {
  const auto& [grazing_angle_deg, free_step] = options;
  hash.add(grazing_angle_deg, free_step);
}

namespace {

void add_samples(const RangeView& view, ContentHash& hash) {
  const auto& [name, camera, range, normals, confidence, deviation, colours, world_from_view, pose,
               samples] = view;
  hash.add(camera, range, normals, confidence, deviation, colours, samples);
}

}  // namespace

std::string hash_of_samples(const RangeView& view) {
  ContentHash hash;
  add_samples(view, hash);
  return hash.hex();
}

std::string hash_of_view(const RangeView& view) {
  ContentHash hash;
  add_samples(view, hash);
  hash.add(view.name, view.world_from_view, view.pose);
  return hash.hex();
}

std::vector<std::string> hashes_of_views(const std::vector<RangeView>& views) {
  return parallel_map<std::string>(views.size(),
                                   [&](std::size_t i) { return hash_of_view(views[i]); });
}

}  // namespace relief
