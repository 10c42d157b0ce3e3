#include "registration/verification/still_samples.h"

#include <algorithm>
#include <cstddef>

#include "scan/background/depth_stack.h"

namespace relief::registration {

namespace {

constexpr std::size_t kCompared = 16;  // Views at most, evenly over all; bounds the time.
constexpr std::size_t kFewest = 2;

// The range at the middle of the samples, for the comparison of rays.
double mean_range(const RangeView& view) {
  double sum = 0.0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) sum += view.range(u, v);
  return sum / static_cast<double>(std::max<std::size_t>(1, view.sample_count()));
}

std::vector<std::size_t> views_of_camera(const RangeView& view,
                                         const std::vector<const RangeView*>& others) {
  std::vector<std::size_t> same, chosen;
  const double range = mean_range(view);
  for (std::size_t j = 0; j < others.size(); ++j)
    if (same_rays(view.camera, others[j]->camera, range)) same.push_back(j);
  const std::size_t count = std::min(kCompared, same.size());
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(same[k * same.size() / count]);
  return chosen;
}

}  // namespace

double still_fraction(const RangeView& view, const RigidMotion& world_from_view,
                      const std::vector<const RangeView*>& others,
                      const std::vector<RigidMotion>& world_from_others, double tolerance) {
  const auto compared = views_of_camera(view, others);
  if (compared.size() < kFewest || view.sample_count() == 0) return 0.0;
  std::size_t still = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector3d point = view.point(u, v);
      std::size_t alike = 0;
      for (const std::size_t j : compared)
        if (others[j]->has_sample(u, v) && (others[j]->point(u, v) - point).norm() <= tolerance &&
            (world_from_others[j] * point - world_from_view * point).norm() > 2.0 * tolerance)
          ++alike;
      if (2 * alike > compared.size()) ++still;
    }
  }
  return static_cast<double>(still) / static_cast<double>(view.sample_count());
}

}  // namespace relief::registration
