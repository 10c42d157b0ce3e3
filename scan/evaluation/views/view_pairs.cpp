#include "scan/evaluation/views/view_pairs.h"

#include <string>
#include <utility>

namespace relief::evaluation {

namespace {

// How far apart the two rays of a pixel are: at most `kRayTolerance` of a pixel. Files keep
// intrinsics and ray tables to about seven digits: 1e-7 is 0.007 pixels of an image of 65536.
constexpr double kRayTolerance = 1e-2;

bool same_rays(const RangeView& a, const RangeView& b) {
  const int right = a.width() - 1, bottom = a.height() - 1;
  for (const auto& [u, v] : {std::pair{0, 0}, {right, 0}, {0, bottom}, {right, bottom}}) {
    const Ray ra = a.camera.ray(u, v), rb = b.camera.ray(u, v);
    const Ray next = b.camera.ray(u + (u == 0 && right > 0 ? 1 : -(right > 0)), v);
    const double range = 1.0;  // rays are compared at this multiple of their directions
    const Eigen::Vector3d direction = rb.direction.normalized();
    const auto off_ray = [&](const Eigen::Vector3d& point) {
      const Eigen::Vector3d offset = point - rb.origin;
      return (offset - offset.dot(direction) * direction).norm();
    };
    const double pixel = off_ray(next.at(range)) + off_ray(next.origin);
    if (off_ray(ra.at(range)) + off_ray(ra.origin) > kRayTolerance * pixel ||
        ra.direction.dot(rb.direction) <= 0.0)
      return false;
  }
  return true;
}

Error mismatch(const RangeView& view, const std::string& what) {
  return {ErrorKind::kBadInput,
          "view " + view.name + " cannot be compared with its truth: " + what};
}

Result<void> check_comparable(const RangeView& view, const RangeView& truth) {
  if (view.width() != truth.width() || view.height() != truth.height())
    return mismatch(view, "it has " + std::to_string(view.width()) + "x" +
                              std::to_string(view.height()) + " pixels, the truth " +
                              std::to_string(truth.width()) + "x" + std::to_string(truth.height()));
  if (view.width() == 0 || view.height() == 0) return mismatch(view, "they have no pixels");
  if (!same_rays(view, truth)) return mismatch(view, "their cameras have different rays");
  return {};
}

}  // namespace

Result<std::vector<ViewAndTruth>> pair_views(const ScanProject& result, const ScanProject& truth) {
  std::vector<ViewAndTruth> pairs;
  for (const RangeView& view : result.views) {
    const RangeView* true_view = find_view(truth, view.name);
    if (!true_view) return mismatch(view, "the truth has no view of this name");
    if (const auto valid = check_comparable(view, *true_view); !valid) return valid.error();
    pairs.push_back({&view, true_view});
  }
  return pairs;
}

double depth_error(const ViewAndTruth& pair, int u, int v) {
  const Eigen::Vector3d offset = pair.view->point(u, v) - pair.truth->point(u, v);
  return offset.dot(pair.truth->camera.ray(u, v).direction.normalized());
}

}  // namespace relief::evaluation
