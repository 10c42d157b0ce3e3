#include <cassert>
#include <cstddef>

#include "relief/registration/align_views.h"

namespace relief::registration {

void apply_alignment(const Alignment& alignment, std::vector<RangeView>& views) {
  assert(alignment.views.size() == views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewReport& report = alignment.views[i];
    RangeView& view = views[i];
    if (!report.aligned) {
      if (view.pose == PoseKind::kGuess) view.pose = PoseKind::kAbsent;
      continue;
    }
    view.world_from_view = report.world_from_view;
    if (view.pose == PoseKind::kAbsent) view.pose = PoseKind::kGuess;
  }
}

}  // namespace relief::registration
