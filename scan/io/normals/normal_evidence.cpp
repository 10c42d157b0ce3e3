#include "scan/io/normals/normal_evidence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scan/base/median.h"

namespace relief {

Eigen::Matrix3d NormalEvidence::view_from_stored(const NormalConvention& convention) const {
  return (convention.space == NormalSpace::kWorld ? view_from_world : view_from_camera) *
         convention.space_from_stored;
}

NormalAgreement agreement(const NormalEvidence& evidence, const NormalConvention& convention) {
  const Eigen::Matrix3d to_view = evidence.view_from_stored(convention);
  std::vector<double> angles, variances;
  for (const NormalPatch& patch : evidence.patches.patches) {
    const double cosine = patch.surface.dot(to_view * patch.stored);
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
    variances.push_back(patch.stddev * patch.stddev);
  }
  NormalAgreement found;
  found.median = median(angles);
  // The median square of two normal deviates is 2 ln 2 of their variance.
  const double noise = 2.0 * std::numbers::ln2 * median(variances);
  found.bias = std::sqrt(std::max(0.0, found.median * found.median - noise));
  return found;
}

}  // namespace relief
