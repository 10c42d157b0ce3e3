#include "scan/io/workspaces/rgbd/mirrored_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/depth_differences.h"

namespace relief {

namespace {

constexpr std::size_t kPairs = 4;           // of neighbouring frames; bounds the time
constexpr int kStep = 8;                    // pixels between those compared; bounds the time
constexpr std::size_t kEnoughPixels = 200;  // for a median that chance does not decide
// How much better the other sign must agree. Scenes that are their own mirror image agree alike; of
// the views of a room (ICL-NUIM) the right sign agrees nine times better.
constexpr double kFarBetter = 4.0;

struct PosedDepth {
  Image depth;  // In the project's unit.
  RigidMotion world_from_view;
};

std::optional<PosedDepth> read_posed_depth(const ViewSpec& view) {
  if (!view.depth || view.pose == PoseKind::kAbsent) return std::nullopt;
  auto depth = read_image(view.depth->file, view.depth->size);
  if (!depth || depth->channels != 1) return std::nullopt;
  for (float& z : depth->samples) z *= static_cast<float>(view.depth->scale);
  return PosedDepth{std::move(*depth), view.world_from_view};
}

std::vector<Eigen::Vector3d> points_in_world(const PosedDepth& from, const PinholeIntrinsics& k) {
  const Camera camera = Camera::pinhole(from.depth.width, from.depth.height, k);
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < from.depth.height; v += kStep)
    for (int u = 0; u < from.depth.width; u += kStep)
      if (const double z = from.depth(u, v); z > 0.0 && std::isfinite(z))
        points.push_back(from.world_from_view * camera.ray(u, v).at(z));
  return points;
}

// Differences of one frame's depths in the next, with fy as it is and with the other sign.
struct Differences {
  std::array<std::vector<double>, 2> of_sign;

  void add(const PosedDepth& from, const PosedDepth& onto, PinholeIntrinsics intrinsics) {
    for (auto& all : of_sign) {
      const auto found = depth_differences(onto.depth, intrinsics, onto.world_from_view,
                                           points_in_world(from, intrinsics));
      all.insert(all.end(), found.begin(), found.end());
      intrinsics.fy = -intrinsics.fy;
    }
  }

  bool enough() const {
    return std::all_of(of_sign.begin(), of_sign.end(),
                       [](const auto& all) { return all.size() >= kEnoughPixels; });
  }

  double median(std::size_t sign) {
    auto& all = of_sign[sign];
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    return *middle;
  }
};

std::string note_text(const PinholeIntrinsics& k, double as_given, double mirrored) {
  char text[400];
  std::snprintf(text, sizeof text,
                "with fy = %g the depth maps disagree at their poses by %.2g %% of the depth, with "
                "fy = %g by %.2g %%: the images seem mirrored, or y of the cameras upwards; give "
                "--intrinsics %g %g %g %g",
                k.fy, 100.0 * as_given, -k.fy, 100.0 * mirrored, k.fx, -k.fy, k.cx, k.cy);
  return text;
}

}  // namespace

std::optional<std::string> note_on_mirrored_images(const ProjectSpec& project) {
  const std::size_t frames = project.views.size();
  if (frames < 2 || !project.views.front().camera) return std::nullopt;
  const PinholeIntrinsics& intrinsics = project.views.front().camera->intrinsics;
  const std::size_t step = std::max<std::size_t>(1, (frames - 1) / kPairs);
  Differences differences;
  for (std::size_t i = 0; i + 1 < frames; i += step) {
    const auto from = read_posed_depth(project.views[i]);
    const auto onto = read_posed_depth(project.views[i + 1]);
    if (from && onto) differences.add(*from, *onto, intrinsics);
  }
  if (!differences.enough()) return std::nullopt;
  const double as_given = differences.median(0), mirrored = differences.median(1);
  if (!(as_given > kFarBetter * mirrored)) return std::nullopt;
  return note_text(intrinsics, as_given, mirrored);
}

}  // namespace relief
