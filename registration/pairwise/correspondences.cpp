#include "registration/pairwise/correspondences.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

// Samples that are tried before what they found is counted: up to 511 more than wanted are found.
constexpr std::size_t kBatch = 512;
// The smallest standard deviation taken for true [sample spacings]: exact data has none, and its
// poses err by as much (docs/results.md, Poses against the least error possible).
constexpr double kLeastSigma = 1e-3;

// The target's surface where it sees `point`. The foot of the point on the tangent plane there is
// looked up once more: at oblique incidence the first pixel is far from the closest one.
std::optional<SurfacePoint> projected(const ViewSurface& target, const Eigen::Vector3d& point,
                                      SurfacePart part) {
  const auto pixel = target.project(point);
  if (!pixel) return std::nullopt;
  const auto first = target.nearest(*pixel, part);
  if (!first) return std::nullopt;
  const double distance = first->normal.dot(point - first->point);
  const auto foot_pixel = target.project(point - distance * first->normal);
  return foot_pixel ? target.at(*foot_pixel, part) : std::nullopt;
}

std::vector<std::optional<SurfacePoint>> counterparts(const ViewSurface& target,
                                                      const Eigen::Matrix3Xd& points,
                                                      bool projective, SurfacePart part) {
  std::vector<std::optional<SurfacePoint>> found(static_cast<std::size_t>(points.cols()));
  if (projective) {
    for (std::size_t i = 0; i < found.size(); ++i)
      found[i] = projected(target, points.col(static_cast<Eigen::Index>(i)), part);
  } else {
    const auto pixels = target.closest(points);
    for (std::size_t i = 0; i < found.size(); ++i) found[i] = target.at(pixels[i]);
  }
  return found;
}

bool associates_by_projection(const ViewSurface& target, Association association) {
  const bool projective = association == Association::kProjective ||
                          (association == Association::kAuto && target.can_project());
  assert(projective ? target.can_project() : target.has_neighbour_index());
  return projective;
}

// Adds what passes the distance and normal tests out of one batch of samples.
void match_batch(const ViewSurface& target, const RigidMotion& target_from_source,
                 const std::vector<SurfacePoint>& batch, const CorrespondenceOptions& options,
                 bool projective, std::vector<Correspondence>& out) {
  Eigen::Matrix3Xd points(3, batch.size());
  for (std::size_t i = 0; i < batch.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = target_from_source * batch[i].point;
  const auto found = counterparts(target, points, projective, options.part);
  const double least_cosine = std::cos(options.max_normal_angle_deg * std::numbers::pi / 180.0);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (!found[i]) continue;
    const Eigen::Vector3d offset = points.col(static_cast<Eigen::Index>(i)) - found[i]->point;
    if (!(offset.norm() <= options.max_distance)) continue;
    if ((target_from_source.linear() * batch[i].normal).dot(found[i]->normal) < least_cosine)
      continue;
    out.push_back({batch[i], *found[i], found[i]->normal.dot(offset),
                   batch[i].confidence * found[i]->confidence});
  }
}

void reject_distant(Correspondences& found, double max_sigmas, double least_sigma) {
  std::vector<double> distances;
  for (const auto& c : found.items) distances.push_back(c.distance);
  found.sigma = std::max(robust_sigma(std::move(distances)), least_sigma);
  const double limit = max_sigmas * found.sigma;
  std::erase_if(found.items, [&](const Correspondence& c) { return std::abs(c.distance) > limit; });
}

}  // namespace

Correspondences find_correspondences(const ViewSurface& source, const ViewSurface& target,
                                     const RigidMotion& target_from_source,
                                     const CorrespondenceOptions& options) {
  assert(options.count > 0 && options.max_distance > 0.0);
  Correspondences found;
  if (source.samples().empty() || target.samples().empty()) return found;
  const auto wanted = static_cast<std::size_t>(options.count);
  const std::size_t limit =
      std::min(source.samples().size(), wanted * static_cast<std::size_t>(options.tries));
  const std::span<const std::uint32_t> samples(source.samples());
  while (found.tried < limit && found.items.size() < wanted) {
    const std::size_t end = std::min(limit, found.tried + kBatch);
    append_correspondences(source, target, target_from_source,
                           samples.subspan(found.tried, end - found.tried), options, found.items);
    found.tried = end;
  }
  reject_distant(found, options.max_sigmas, kLeastSigma * target.spacing());
  return found;
}

void append_correspondences(const ViewSurface& source, const ViewSurface& target,
                            const RigidMotion& target_from_source,
                            std::span<const std::uint32_t> samples,
                            const CorrespondenceOptions& options,
                            std::vector<Correspondence>& found) {
  const bool projective = associates_by_projection(target, options.association);
  std::vector<SurfacePoint> batch;
  batch.reserve(samples.size());
  for (const std::uint32_t index : samples) batch.push_back(source.sample(index));
  match_batch(target, target_from_source, batch, options, projective, found);
}

double rms_distance(const std::vector<Correspondence>& correspondences) {
  if (correspondences.empty()) return 0.0;
  double sum = 0.0;
  for (const auto& c : correspondences) sum += c.distance * c.distance;
  return std::sqrt(sum / static_cast<double>(correspondences.size()));
}

}  // namespace relief::registration
