#include "registration/verification/unsettled_poses.h"

#include <algorithm>
#include <cstddef>
#include <iomanip>
#include <sstream>
#include <string>
#include <utility>

#include "registration/pairwise/robust.h"

namespace relief::registration {

double median_deviation(const Alignment& alignment) {
  std::vector<double> deviations;
  for (const ViewReport& view : alignment.views)
    if (view.aligned && !view.pose_std.isZero(0.0))
      deviations.push_back(view.pose_std.tail<3>().norm());
  return deviations.empty() ? 0.0 : quantile(std::move(deviations), 0.5);
}

void doubt_unsettled_poses(const std::vector<RangeView>& views, Alignment& alignment) {
  const double deviation = median_deviation(alignment);
  if (alignment.termination != RefinementTermination::kIterationLimit || deviation == 0.0 ||
      !(alignment.last_motion > std::max(deviation, alignment.spacing)))
    return;
  std::ostringstream reason;
  reason << std::setprecision(2) << "refining did not settle: its last step still moved views by "
         << alignment.last_motion / alignment.spacing << " sample spacings, "
         << alignment.last_motion / deviation
         << " times what poses would err by; check the given poses, the focal length and the depth "
            "scale";
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewReport& view = alignment.views[i];
    if (view.status != PoseStatus::kVerified || views[i].pose == PoseKind::kKnown) continue;
    view.status = PoseStatus::kUnverified;
    view.reason = reason.str();
  }
}

}  // namespace relief::registration
