#include "relief/rendering/render_mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "scan/base/parallel.h"
#include "scan/rendering/rays/ray_caster.h"
#include "scan/rendering/styles/paint.h"

namespace relief::rendering {

struct MeshScene::Parts {
  TriangleMesh mesh;
  RayCaster caster;
  PagedVector<Eigen::Vector3f> geometry_normals;
  double diagonal = 0.0;
};

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Traces the rays of one picture.
class PictureRays {
 public:
  PictureRays(const TriangleMesh& mesh, const PagedVector<Eigen::Vector3f>& geometry_normals,
              const RayCaster& caster, const PictureCamera& camera, const RenderOptions& options)
      : mesh_(mesh), caster_(caster), camera_(camera), options_(options) {
    if (options.normals == ShadingNormals::kGeometry ||
        (options.normals == ShadingNormals::kOwn && mesh.normals.size() != mesh.vertices.size()))
      normals_ = &geometry_normals;
    else if (options.normals == ShadingNormals::kOwn)
      normals_ = &mesh.normals;
  }

  std::optional<RayCaster::Hit> hit(double x, double y) const {
    return caster_.first_hit(camera_.ray(x, y), camera_.rays_start_at_sensor());
  }

  // Least and largest range at the centres of the pixels; 0, 1 for a picture without surface.
  std::array<double, 2> ranges() const {
    std::vector<std::array<double, 2>> rows(static_cast<std::size_t>(camera_.height),
                                            {kInfinity, -kInfinity});
    parallel_rows(camera_.height, [&](int y) {
      auto& [least, largest] = rows[static_cast<std::size_t>(y)];
      for (int x = 0; x < camera_.width; ++x) {
        const auto found = hit(x, y);
        if (!found) continue;
        least = std::min(least, found->range);
        largest = std::max(largest, found->range);
      }
    });
    std::array<double, 2> all{kInfinity, -kInfinity};
    for (const auto& [least, largest] : rows)
      all = {std::min(all[0], least), std::max(all[1], largest)};
    return all[0] <= all[1] ? all : std::array<double, 2>{0.0, 1.0};
  }

  Rgba pixel(int x, int y, const Paint& paint) const {
    const int n = options_.antialiasing;
    LinearColour sum = LinearColour::Zero();
    int hits = 0;
    for (int i = 0; i < n * n; ++i) {
      const double sub_x = x + (i % n + 0.5) / n - 0.5, sub_y = y + (i / n + 0.5) / n - 0.5;
      const Ray ray = camera_.ray(sub_x, sub_y);
      const auto found = caster_.first_hit(ray, camera_.rays_start_at_sensor());
      if (!found) continue;
      const auto pixel = static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(camera_.width) +
                         static_cast<std::uint64_t>(x);
      sum += paint(
          surface_point(*found, ray.direction,
                        pixel * static_cast<std::uint64_t>(n * n) + static_cast<std::uint64_t>(i)));
      ++hits;
    }
    return blended(sum, hits, n * n);
  }

 private:
  VisiblePoint surface_point(const RayCaster::Hit& hit, const Eigen::Vector3d& direction,
                             std::uint64_t stream) const {
    VisiblePoint point;
    point.face = hit.face;
    point.weights = hit.weights;
    point.place = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) point.place += hit.weights[k] * mesh_.corner(hit.face, k);
    point.range = hit.range;
    point.stream = stream;
    const Eigen::Vector3d outward = face_cross(mesh_, hit.face).stableNormalized();
    point.back = outward.dot(direction) > 0.0;
    point.face_normal = point.back ? Eigen::Vector3d(-outward) : outward;
    point.normal = shading_normal(point, outward);
    return point;
  }

  // The face's normal where the vertices have none.
  Eigen::Vector3d shading_normal(const VisiblePoint& point, const Eigen::Vector3d& outward) const {
    if (!normals_) return point.face_normal;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      sum += point.weights[k] * (*normals_)[mesh_.faces[point.face][k]].cast<double>();
    if (!sum.allFinite() || !(sum.norm() > 0.0)) return point.face_normal;
    // The sides are those of the faces, whichever way the normals of a file point.
    const bool flip = (sum.dot(outward) < 0.0) != point.back;
    return (flip ? -1.0 : 1.0) * sum.normalized();
  }

  Rgba blended(const LinearColour& sum, int hits, int rays) const {
    if (hits == 0) return background_colour(options_.background);
    const bool transparent = options_.background == Background::kTransparent;
    const LinearColour light =
        transparent ? LinearColour(sum / hits) : LinearColour((sum + double(rays - hits)) / rays);
    const Colour colour = srgb_of(light);
    const auto opacity = transparent ? static_cast<std::uint8_t>(std::lround(255.0 * hits / rays))
                                     : std::uint8_t{255};
    return {colour[0], colour[1], colour[2], opacity};
  }

  const TriangleMesh& mesh_;
  const PagedVector<Eigen::Vector3f>* normals_ = nullptr;  // Null: those of the faces.
  const RayCaster& caster_;
  const PictureCamera& camera_;
  const RenderOptions& options_;
};

}  // namespace

Result<MeshScene> MeshScene::of(TriangleMesh mesh) {
  auto caster = RayCaster::of(mesh);
  if (!caster) return caster.error();
  auto normals = vertex_normals(mesh);
  const double diagonal = bounding_box(mesh).diagonal().norm();
  return MeshScene(std::make_shared<const Parts>(
      Parts{std::move(mesh), *std::move(caster), std::move(normals), diagonal}));
}

const TriangleMesh& MeshScene::mesh() const { return parts_->mesh; }

Result<Rendering> MeshScene::render(const PictureCamera& camera, RenderStyle style,
                                    const RenderOptions& options) const {
  assert(camera.width >= 1 && camera.height >= 1 && options.antialiasing >= 1);
  const PictureRays rays(parts_->mesh, parts_->geometry_normals, parts_->caster, camera, options);
  PaintContext context{parts_->mesh, parts_->caster, parts_->diagonal, camera.picture_axes(),
                       {},           options};
  if (style == RenderStyle::kDepth && !options.range) context.ranges = rays.ranges();
  const auto paint = paint_of(style, context);
  if (!paint) return paint.error();
  Rendering rendering{Picture(camera.width, camera.height), paint->legend};
  parallel_rows(camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) rendering.picture(x, y) = rays.pixel(x, y, paint->paint);
  });
  return rendering;
}

Result<Rendering> render_mesh(const TriangleMesh& mesh, const PictureCamera& camera,
                              RenderStyle style, const RenderOptions& options) {
  const auto scene = MeshScene::of(mesh);
  if (!scene) return scene.error();
  return scene->render(camera, style, options);
}

TriangleMesh surface_of_view(const RangeView& view) {
  TriangleMesh mesh = mesh_from_view(view);
  if (view.deviation.empty()) return mesh;
  // The vertices are the samples, row by row.
  mesh.quality.reserve(mesh.vertices.size());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) mesh.quality.push_back(view.deviation(u, v));
  return mesh;
}

}  // namespace relief::rendering
