#include "scan/rendering/rays/ray_caster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/Geometry>
#include <embree3/rtcore.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "scan/base/parallel.h"

namespace relief::rendering {

namespace {

// Of the mesh's radius. 300 times the rounding of floats, 2^-24, and 1/270 of the side of a face of
// a sphere of a million.
constexpr double kOffset = 2e-5;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Result<void> check(const TriangleMesh& mesh) {
  if (mesh.faces.empty())
    return Error{ErrorKind::kBadInput,
                 "the mesh has no faces: give a surface, or render points as a project of views"};
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      return Error{ErrorKind::kBadInput,
                   "vertex " + std::to_string(i) + " of the mesh is not finite"};
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (const std::uint32_t vertex : mesh.faces[f])
      if (vertex >= mesh.vertices.size())
        return Error{ErrorKind::kBadInput, "face " + std::to_string(f) +
                                               " of the mesh names vertex " +
                                               std::to_string(vertex) + ", which does not exist"};
  return {};
}

void set(RTCRay& ray, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, float far) {
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = 0.0f;
  ray.tfar = far;
  ray.time = 0.0f;
  ray.mask = 0xffffffffu;
  ray.id = 0;
  ray.flags = 0;
}

}  // namespace

struct RayCaster::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Embree() {
    // One instruction set on all machines, so that all give the same bytes; the one that the
    // project is built for.
    device = rtcNewDevice("isa=sse4.2");
    if (device) scene = rtcNewScene(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;
  ~Embree() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  bool add(const TriangleMesh& mesh, const Eigen::Vector3d& centre, double radius) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* places = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
    auto* corners = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.faces.size()));
    const bool allocated = places && corners;
    if (allocated) {
      for (const auto& vertex : mesh.vertices)
        for (int k = 0; k < 3; ++k)
          *places++ = static_cast<float>((vertex[k] - centre[k]) / radius);
      for (const auto& face : mesh.faces) corners = std::copy(face.begin(), face.end(), corners);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene, geometry);
    }
    rtcReleaseGeometry(geometry);
    return allocated;
  }

  void commit() {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const int workers = std::min(thread_count(), tbb::info::default_concurrency());
    tbb::task_arena(workers).execute([this] { rtcCommitScene(scene); });
  }
};

Result<RayCaster> RayCaster::of(const TriangleMesh& mesh) {
  if (auto valid = check(mesh); !valid) return valid.error();
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  RayCaster caster;
  caster.centre_ = box.center();
  caster.radius_ = 0.5 * box.diagonal().norm();
  if (!(caster.radius_ > 0.0))
    return Error{ErrorKind::kBadInput, "the mesh has no extent: all vertices are at one place"};
  auto embree = std::make_shared<Embree>();
  const bool added = embree->scene && embree->add(mesh, caster.centre_, caster.radius_);
  if (added) embree->commit();
  if (!added || rtcGetDeviceError(embree->device) != RTC_ERROR_NONE)
    return Error{ErrorKind::kUnsolvable, "not enough memory for the rays of a mesh of " +
                                             std::to_string(mesh.faces.size()) +
                                             " faces: reduce it, or free memory"};
  caster.embree_ = std::move(embree);
  return caster;
}

std::optional<RayCaster::Hit> RayCaster::first_hit(const Ray& ray, bool from_origin) const {
  // In the frame of the sphere of radius 1 round the mesh, with ranges of a unit direction.
  const double length = ray.direction.norm() / radius_;
  const Eigen::Vector3d direction = ray.direction.normalized();
  const Eigen::Vector3d origin = (ray.origin - centre_) / radius_;
  const double closest = -origin.dot(direction);
  if ((origin + closest * direction).squaredNorm() > 1.0 + 1e-6) return std::nullopt;
  const double start = from_origin ? std::max(0.0, closest - 1.01) : closest - 1.01;

  RTCRayHit query;
  set(query.ray, origin + start * direction, direction, kInfinity);
  query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const double u = query.hit.u, v = query.hit.v;
  return Hit{query.hit.primID, {1.0 - u - v, u, v}, (start + double{query.ray.tfar}) / length};
}

bool RayCaster::is_blocked(const Eigen::Vector3d& point, const Eigen::Vector3d& side,
                           const Eigen::Vector3d& direction, double reach) const {
  RTCRay ray;
  set(ray, (point - centre_) / radius_ + kOffset * side, direction,
      static_cast<float>(reach / radius_));
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace relief::rendering
