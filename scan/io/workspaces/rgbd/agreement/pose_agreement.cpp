#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scan/base/median.h"
#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/depth_differences.h"

namespace relief {

namespace {

constexpr std::size_t kFrameSteps = 4;      // between frames compared with all; bounds the time
constexpr int kPixelStep = 8;               // between pixels compared; bounds the time
constexpr std::size_t kEnoughPixels = 200;  // for a median that chance does not decide
constexpr double kSamePose = 1e-9;          // relative to the pose: rounding

std::optional<Image> read_depth(const ViewSpec& view) {
  if (!view.depth || !view.camera || view.pose == PoseKind::kAbsent) return std::nullopt;
  auto depth = read_depth_image(view.depth->file, view.depth->size);
  if (!depth) return std::nullopt;
  return std::move(*depth);
}

// Depths along the optical axis of a map of distances along the rays.
Image along_axis(Image depth, const PinholeIntrinsics& k) {
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      depth(u, v) /=
          static_cast<float>(Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0).norm());
  return depth;
}

std::vector<Eigen::Vector3d> points_in_world(const Image& depth, const PinholeIntrinsics& k,
                                             const RigidMotion& world_from_view) {
  const Camera camera = Camera::pinhole(depth.width, depth.height, k);
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < depth.height; v += kPixelStep)
    for (int u = 0; u < depth.width; u += kPixelStep)
      if (const double z = depth(u, v); z > 0.0 && std::isfinite(z))
        points.push_back(world_from_view * camera.ray(u, v).at(z));
  return points;
}

// The origin where there are none.
Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

// Takes out what stands still in all frames, as the table under an object that turns.
void take_out_still_pixels(std::map<std::size_t, Image>& depths) {
  if (depths.empty()) return;
  auto nearest = depths.begin()->second.samples, farthest = nearest;
  for (const auto& [frame, depth] : depths) {
    if (depth.samples.size() != nearest.size()) return;
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      nearest[i] = std::min(nearest[i], depth.samples[i]);
      farthest[i] = std::max(farthest[i], depth.samples[i]);
    }
  }
  for (auto& [frame, depth] : depths)
    for (std::size_t i = 0; i < nearest.size(); ++i)
      if (farthest[i] - nearest[i] < kCameraError * nearest[i]) depth.samples[i] = 0.0f;
}

// A few frames with the ones after them, which overlap, and with each other, whose poses tell more
// of the scale.
std::vector<std::pair<std::size_t, std::size_t>> pairs_to_compare(std::size_t frames) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  if (frames < 2) return pairs;
  const std::size_t step = std::max<std::size_t>(1, (frames - 1) / kFrameSteps);
  for (std::size_t i = 0; i + 1 < frames; i += step) {
    if (step > 1) pairs.emplace_back(i, i + 1);
    for (std::size_t j = i + step; j < frames; j += step) pairs.emplace_back(i, j);
  }
  return pairs;
}

// A depth map in the unit of the poses, its depths along the optical axis.
Image depth_as_read(Image depth, const ViewSpec& view, bool along_ray) {
  for (float& z : depth.samples) z *= static_cast<float>(view.depth->scale);
  return along_ray ? along_axis(std::move(depth), view.camera->intrinsics) : std::move(depth);
}

bool at_the_same_pose(const ViewSpec& a, const ViewSpec& b) {
  return a.world_from_view.isApprox(b.world_from_view, kSamePose);
}

}  // namespace

bool has_ray_lengths(const ProjectSpec& project) {
  return std::ranges::any_of(
      project.views, [](const ViewSpec& view) { return view.depth && view.depth->along_ray; });
}

ComparedDepths::ComparedDepths(const ProjectSpec& project)
    : pairs_(pairs_to_compare(project.views.size())) {
  for (const auto& [a, b] : pairs_)
    for (const std::size_t i : {a, b})
      if (!depths_.contains(i))
        if (auto depth = read_depth(project.views[i])) depths_.emplace(i, std::move(*depth));
  take_out_still_pixels(depths_);
}

std::vector<std::optional<Disagreement>> ComparedDepths::disagreements(
    const ProjectSpec& project, const std::vector<DepthReading>& readings) const {
  std::array<std::map<std::size_t, Image>, 2> depths;  // Along the axis, along the rays.
  for (const DepthReading& reading : readings)
    for (const auto& [i, depth] : depths_)
      if (auto& read = depths[reading.along_ray ? 1 : 0]; !read.contains(i))
        read.emplace(i, depth_as_read(depth, project.views[i], reading.along_ray));
  std::vector<std::vector<double>> differences(readings.size());
  for (const auto& [a, b] : pairs_) {
    const ViewSpec &from = project.views[a], &onto = project.views[b];
    if (!depths_.contains(a) || !depths_.contains(b) || at_the_same_pose(from, onto)) continue;
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const auto& read = depths[readings[k].along_ray ? 1 : 0];
      const PoseConvention& poses = readings[k].poses;
      const RigidMotion world_from_a = poses.world_from_view(from.world_from_view),
                        world_from_b = poses.world_from_view(onto.world_from_view);
      const auto points = points_in_world(read.at(a), from.camera->intrinsics, world_from_a);
      const RigidMotion a_from_world = world_from_a.inverse();
      if (!poses.as_given() &&
          only_rolls(world_from_b.inverse() * world_from_a, a_from_world * mean_of(points)))
        continue;
      const auto found =
          depth_differences(read.at(b), onto.camera->intrinsics, world_from_b, points);
      differences[k].insert(differences[k].end(), found.begin(), found.end());
    }
  }
  std::vector<std::optional<Disagreement>> found(readings.size());
  for (std::size_t k = 0; k < readings.size(); ++k)
    if (const std::size_t pixels = differences[k].size(); pixels >= kEnoughPixels)
      found[k] = Disagreement{median(std::move(differences[k])), pixels};
  return found;
}

}  // namespace relief
