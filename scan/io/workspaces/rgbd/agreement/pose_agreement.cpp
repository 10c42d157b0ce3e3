#include "scan/io/workspaces/rgbd/agreement/pose_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "scan/base/median.h"
#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/depth_differences.h"

namespace relief {

namespace {

constexpr std::size_t kFrameSteps = 4;      // between frames compared with all; bounds the time
constexpr int kPixelStep = 8;               // between pixels compared; bounds the time
constexpr std::size_t kEnoughPixels = 200;  // for a median that chance does not decide

struct PosedDepth {
  Image depth;
  RigidMotion world_from_view;
};

std::optional<PosedDepth> read_posed_depth(const ViewSpec& view) {
  if (!view.depth || view.pose == PoseKind::kAbsent) return std::nullopt;
  auto depth = read_image(view.depth->file, view.depth->size);
  if (!depth || depth->channels != 1) return std::nullopt;
  for (float& z : depth->samples) z *= static_cast<float>(view.depth->scale);
  return PosedDepth{std::move(*depth), view.world_from_view};
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

// The frame in a world of which `factor` is the unit: depths keep their values, and agree as
// before.
RigidMotion pose_in_units(const PosedDepth& frame, double factor) {
  RigidMotion pose = frame.world_from_view;
  pose.translation() /= factor;
  return pose;
}

}  // namespace

std::vector<std::optional<double>> disagreements_at_poses(
    const ProjectSpec& project, const std::vector<DepthReading>& readings) {
  std::map<std::size_t, std::optional<PosedDepth>> frames;
  std::vector<std::vector<double>> differences(readings.size());
  for (const auto& [a, b] : pairs_to_compare(project.views.size())) {
    for (const std::size_t i : {a, b})
      if (!frames.contains(i)) frames[i] = read_posed_depth(project.views[i]);
    const auto &from = frames[a], &onto = frames[b];
    if (!from || !onto) continue;
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const auto& [intrinsics, factor, along_ray] = readings[k];
      const auto compare = [&](const Image& of_from, const Image& of_onto) {
        return depth_differences(
            of_onto, intrinsics, pose_in_units(*onto, factor),
            points_in_world(of_from, intrinsics, pose_in_units(*from, factor)));
      };
      const auto found = along_ray ? compare(along_axis(from->depth, intrinsics),
                                             along_axis(onto->depth, intrinsics))
                                   : compare(from->depth, onto->depth);
      differences[k].insert(differences[k].end(), found.begin(), found.end());
    }
  }
  std::vector<std::optional<double>> medians(readings.size());
  for (std::size_t k = 0; k < readings.size(); ++k)
    if (differences[k].size() >= kEnoughPixels) medians[k] = median(std::move(differences[k]));
  return medians;
}

}  // namespace relief
