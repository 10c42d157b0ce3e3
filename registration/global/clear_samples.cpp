#include "registration/global/clear_samples.h"

#include <algorithm>
#include <cmath>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/search_schedule.h"

namespace relief::registration {

namespace {

constexpr std::size_t kProbes = 3000;  // Of each view; bounds the time.
// From all faces [sample spacings]: edges are rounded by a few, and calibrations bend faces.
constexpr double kClear = 10.0;
// Behind a surface [distances at which samples correspond] a sample is hidden, and 73 degrees off
// the line of sight a sensor hardly measures it.
constexpr double kHidden = 10.0, kFacing = 0.3;
constexpr double kLeastCosine = 0.77;  // 40 degrees, as of correspondences.
// Of the clear samples that are seen, at least, to confirm a pose, and at most where they deny it.
// At right poses of a laser five sixths and more are met, of depth cameras, with what flies at
// edges, half. At wrong ones it is a fifth in one direction, and up to a half in the other.
constexpr double kMet = 0.8, kDeniedMet = 0.3;
constexpr int kFewest = 5;    // Fewer tell nothing of their direction.
constexpr int kTelling = 25;  // Five deviations from none.

bool lacks_some(const ClearSamples& samples) {
  return samples.seen >= kFewest && samples.met < kMet * samples.seen;
}

bool lacks_most(const ClearSamples& samples) {
  return samples.seen >= kTelling && samples.met < kDeniedMet * samples.seen;
}

}  // namespace

ClearSamples find_clear_samples(const ViewSurface& source, const FlatFaces& source_faces,
                                const ViewSurface& target, const FlatFaces& target_faces,
                                const RigidMotion& target_from_source, double min_stddev) {
  ClearSamples found;
  if (!target.can_project()) return found;
  const double reach = finest_search_distance(coarser_spacing(source, target),
                                              std::max(joint_noise(source, target), min_stddev));
  const std::size_t probes = std::min(kProbes, source.samples().size());
  for (std::size_t i = 0; i < probes; ++i) {
    const SurfacePoint sample = source.sample(source.samples()[i]);
    if (!source_faces.is_clear(sample.point, kClear * source.spacing())) continue;
    const Eigen::Vector3d point = target_from_source * sample.point;
    const auto pixel = target.project(point);
    const auto seen = pixel ? target.at(*pixel) : std::nullopt;
    if (!seen) continue;
    const Eigen::Vector3d normal = target_from_source.linear() * sample.normal;
    const double distance = (point - seen->point).dot(seen->normal);
    if (distance < -kHidden * reach || -target.sight(*pixel).normalized().dot(normal) < kFacing)
      continue;
    ++found.seen;
    if (std::abs(distance) > reach || normal.dot(seen->normal) < kLeastCosine) continue;
    ++found.met;
    if (target_faces.is_clear(seen->point, kClear * target.spacing())) ++found.beside;
  }
  return found;
}

ClearVerdict judge_clear_of_faces(const ViewSurface& a, const FlatFaces& a_faces,
                                  const ViewSurface& b, const FlatFaces& b_faces,
                                  const RigidMotion& b_from_a, double min_stddev) {
  const ClearSamples in_b = find_clear_samples(a, a_faces, b, b_faces, b_from_a, min_stddev);
  const ClearSamples in_a =
      find_clear_samples(b, b_faces, a, a_faces, b_from_a.inverse(), min_stddev);
  if (lacks_most(in_b) || lacks_most(in_a)) return ClearVerdict::kDenied;
  if (lacks_some(in_b) || lacks_some(in_a)) return ClearVerdict::kUnknown;
  return in_b.beside + in_a.beside >= kTelling ? ClearVerdict::kConfirmed : ClearVerdict::kUnknown;
}

}  // namespace relief::registration
