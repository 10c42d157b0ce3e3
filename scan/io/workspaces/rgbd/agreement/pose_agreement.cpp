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
constexpr double kSamePose = 1e-9;          // relative to the pose: rounding

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

using PosedDepths = std::map<std::size_t, std::optional<PosedDepth>>;

// Takes out what stands still in all frames, as the table under an object that turns: it disagrees
// at the right poses.
void take_out_still_pixels(PosedDepths& frames) {
  const PosedDepth* first = nullptr;
  for (const auto& [index, frame] : frames) {
    if (!frame) continue;
    if (!first) first = &*frame;
    if (frame->depth.samples.size() != first->depth.samples.size()) return;
  }
  if (!first) return;
  auto nearest = first->depth.samples, farthest = nearest;
  for (const auto& [index, frame] : frames)
    for (std::size_t i = 0; frame && i < nearest.size(); ++i) {
      nearest[i] = std::min(nearest[i], frame->depth.samples[i]);
      farthest[i] = std::max(farthest[i], frame->depth.samples[i]);
    }
  for (auto& [index, frame] : frames)
    for (std::size_t i = 0; frame && i < nearest.size(); ++i)
      if (farthest[i] - nearest[i] < kCameraError * nearest[i]) frame->depth.samples[i] = 0.0f;
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

// As read, in a world of which the factor of depths is the unit: depths keep their values, and
// agree as before.
RigidMotion pose_as_read(const PosedDepth& frame, const DepthReading& reading) {
  RigidMotion pose = reading.poses.world_from_view(frame.world_from_view);
  pose.translation() /= reading.factor;
  return pose;
}

bool at_the_same_pose(const PosedDepth& a, const PosedDepth& b) {
  return a.world_from_view.isApprox(b.world_from_view, kSamePose);
}

}  // namespace

std::vector<std::optional<Disagreement>> disagreements_at_poses(
    const ProjectSpec& project, const std::vector<DepthReading>& readings) {
  const auto pairs = pairs_to_compare(project.views.size());
  PosedDepths frames;
  for (const auto& [a, b] : pairs)
    for (const std::size_t i : {a, b})
      if (!frames.contains(i)) frames[i] = read_posed_depth(project.views[i]);
  take_out_still_pixels(frames);
  std::vector<std::vector<double>> differences(readings.size());
  for (const auto& [a, b] : pairs) {
    const auto &from = frames[a], &onto = frames[b];
    if (!from || !onto || at_the_same_pose(*from, *onto)) continue;
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const PinholeIntrinsics& intrinsics = readings[k].intrinsics;
      const auto compare = [&](const Image& of_from, const Image& of_onto) {
        return depth_differences(
            of_onto, intrinsics, pose_as_read(*onto, readings[k]),
            points_in_world(of_from, intrinsics, pose_as_read(*from, readings[k])));
      };
      const auto found = readings[k].along_ray ? compare(along_axis(from->depth, intrinsics),
                                                         along_axis(onto->depth, intrinsics))
                                               : compare(from->depth, onto->depth);
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
