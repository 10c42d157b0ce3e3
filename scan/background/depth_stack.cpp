#include "scan/background/depth_stack.h"

#include <algorithm>
#include <cmath>

#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

constexpr int kComparedRays = 16;    // along each side of the image; bounds the time
constexpr double kSamePixel = 0.5;   // [pixels]: rays are nearer to each other than to the next
constexpr double kDeviations = 5.0;  // standard deviations; 6e-7 of a Gaussian lies beyond

double median_range(const RangeView& view) {
  std::vector<double> ranges;
  for (const double t : view.range)
    if (t == t) ranges.push_back(t);
  return median(ranges);
}

// The distance of neighbouring rays at a point of the ray of pixel (u, v) [unit].
double footprint(const Camera& camera, int u, int v, const Eigen::Vector3d& point) {
  const int beside = u + 1 < camera.width() ? u + 1 : u - 1;
  if (beside < 0) return 0.0;
  const Ray ray = camera.ray(beside, v);
  return (ray.at(ray.range_of(point)) - point).norm();
}

Grid<float> tolerance_of(const DepthStack& stack) {
  Grid<float> tolerance(stack.camera.width(), stack.camera.height(), 0.0f);
  parallel_rows(tolerance.height(), [&](int v) {
    std::vector<double> sigmas;
    std::vector<float> depths;
    for (int u = 0; u < tolerance.width(); ++u) {
      sigmas.clear();
      depths.clear();
      for (std::size_t i = 0; i < stack.size(); ++i) {
        const float depth = stack.depths[i](u, v);
        if (!(depth == depth)) continue;
        depths.push_back(depth);
        sigmas.push_back(stack.noises[i].sigma_at(u, v));
      }
      if (depths.empty()) continue;
      const Ray ray = stack.camera.ray(u, v);
      const Eigen::Vector3d point = ray.at(median(depths) / ray.direction.norm());
      tolerance(u, v) =
          static_cast<float>(kDeviations * median(sigmas) + footprint(stack.camera, u, v, point));
    }
  });
  return tolerance;
}

}  // namespace

bool same_rays(const Camera& a, const Camera& b, double range) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int j = 0; j < kComparedRays; ++j) {
    for (int i = 0; i < kComparedRays; ++i) {
      const int u = i * (a.width() - 1) / (kComparedRays - 1);
      const int v = j * (a.height() - 1) / (kComparedRays - 1);
      const Eigen::Vector3d point = a.ray(u, v).at(range);
      const Ray other = b.ray(u, v);
      const double off = (other.at(other.range_of(point)) - point).norm();
      if (!(off <= kSamePixel * footprint(a, u, v, point))) return false;
    }
  }
  return true;
}

Grid<float> depths_of(const RangeView& view, const Camera& camera) {
  Grid<float> depths(view.width(), view.height(), static_cast<float>(kNoSample));
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Ray ray = camera.ray(u, v);
      depths(u, v) = static_cast<float>(ray.range_of(view.point(u, v)) * ray.direction.norm());
    }
  }
  return depths;
}

std::vector<DepthStack> stack_depths(const std::vector<const RangeView*>& views) {
  std::vector<DepthStack> stacks;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::size_t k = 0;
    while (k < stacks.size() && !same_rays(stacks[k].camera, views[i]->camera, stacks[k].range))
      ++k;
    if (k == stacks.size()) {
      DepthStack& stack = stacks.emplace_back();
      stack.camera = views[i]->camera;
      stack.range = median_range(*views[i]);
    }
    stacks[k].views.push_back(i);
  }
  for (DepthStack& stack : stacks) {
    stack.depths = parallel_map<Grid<float>>(stack.size(), [&](std::size_t i) {
      return depths_of(*views[stack.views[i]], stack.camera);
    });
    stack.noises = parallel_map<RangeNoise>(
        stack.size(), [&](std::size_t i) { return estimate_range_noise(*views[stack.views[i]]); });
    stack.tolerance = tolerance_of(stack);
  }
  return stacks;
}

}  // namespace relief
