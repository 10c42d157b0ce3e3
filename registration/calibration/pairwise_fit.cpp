#include "registration/calibration/pairwise_fit.h"

#include <cmath>

#include "registration/pairwise/robust.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

PairwiseFit fit_of_pair(const ViewSurface& source, const ViewSurface& target,
                        const RigidMotion& target_from_source,
                        const CorrespondenceOptions& search) {
  const Correspondences found = find_correspondences(source, target, target_from_source, search);
  std::vector<double> distances;
  for (const Correspondence& c : found.items) {
    const double facing = std::abs(c.target.normal.dot(target.sight(c.target.pixel).normalized()));
    if (facing > 0.0) distances.push_back(std::abs(c.distance) / facing);
  }
  return {found.overlap(), quantile(distances, 0.5)};
}

}  // namespace

PairwiseFit measure_fit(const std::vector<ViewSurface>& surfaces,
                        const std::vector<RigidMotion>& world_from_view,
                        const std::vector<ViewPair>& pairs, const CorrespondenceOptions& search) {
  const auto fits = parallel_map<PairwiseFit>(2 * pairs.size(), [&](std::size_t i) {
    const std::size_t source = source_of(pairs, i), target = target_of(pairs, i);
    return fit_of_pair(surfaces[source], surfaces[target],
                       world_from_view[target].inverse() * world_from_view[source], search);
  });
  PairwiseFit sum;
  for (const PairwiseFit& fit : fits) {
    sum.overlap += fit.overlap;
    sum.distance += fit.distance / static_cast<double>(fits.size());
  }
  return sum;
}

}  // namespace relief::registration
