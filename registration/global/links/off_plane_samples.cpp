#include "registration/global/links/off_plane_samples.h"

#include <algorithm>
#include <cmath>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/search_schedule.h"

namespace relief::registration {

namespace {

constexpr std::size_t kProbes = 3000;  // Of each view; bounds the time.
// Behind a surface [distances at which samples correspond] a sample is hidden, and 73 degrees off
// the line of sight a sensor hardly measures it.
constexpr double kHidden = 10.0, kFacing = 0.3;
constexpr double kLeastCosine = 0.77;  // 40 degrees, as of correspondences.
// Of the off-plane samples that are seen, at least, to confirm a pose, and at most where they deny
// it. At right poses of a laser five sixths and more are met, of depth cameras, with what flies at
// edges, half. At wrong ones it is a fifth in one direction, and up to a half in the other.
constexpr double kMet = 0.8, kDeniedMet = 0.3;
constexpr int kFewest = 5;    // Fewer tell nothing of their direction.
constexpr int kTelling = 25;  // Five deviations from none.

// What off-plane samples of one view meet in another.
struct MetSamples {
  int seen = 0;       // Facing its sensor, in front of its surface, on it or little behind it.
  int met = 0;        // Of these on it, with a similar normal.
  int off_plane = 0;  // Of these off the other's faces, too.
};

bool lacks_some(const MetSamples& samples) {
  return samples.seen >= kFewest && samples.met < kMet * samples.seen;
}

bool lacks_most(const MetSamples& samples) {
  return samples.seen >= kTelling && samples.met < kDeniedMet * samples.seen;
}

// None where the target has no projection.
MetSamples find_met_samples(const ViewSurface& source, const FlatFaces& source_faces,
                            const ViewSurface& target, const FlatFaces& target_faces,
                            const RigidMotion& target_from_source, double min_stddev) {
  MetSamples found;
  if (!target.can_project()) return found;
  const double reach = finest_search_distance(coarser_spacing(source, target),
                                              std::max(joint_noise(source, target), min_stddev));
  const std::size_t probes = std::min(kProbes, source.samples().size());
  for (std::size_t i = 0; i < probes; ++i) {
    const SurfacePoint sample = source.sample(source.samples()[i]);
    if (!source_faces.is_off_plane(sample.point, kClearOfFaces * source.spacing())) continue;
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
    if (target_faces.is_off_plane(seen->point, kClearOfFaces * target.spacing())) ++found.off_plane;
  }
  return found;
}

}  // namespace

OffPlaneVerdict judge_off_plane_samples(const ViewSurface& a, const FlatFaces& a_faces,
                                        const ViewSurface& b, const FlatFaces& b_faces,
                                        const RigidMotion& b_from_a, double min_stddev) {
  const MetSamples in_b = find_met_samples(a, a_faces, b, b_faces, b_from_a, min_stddev);
  const MetSamples in_a = find_met_samples(b, b_faces, a, a_faces, b_from_a.inverse(), min_stddev);
  if (lacks_most(in_b) || lacks_most(in_a)) return OffPlaneVerdict::kDenied;
  if (lacks_some(in_b) || lacks_some(in_a)) return OffPlaneVerdict::kUnknown;
  return in_b.off_plane + in_a.off_plane >= kTelling ? OffPlaneVerdict::kConfirmed
                                                     : OffPlaneVerdict::kUnknown;
}

}  // namespace relief::registration
