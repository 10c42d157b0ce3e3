#include "apps/commands/plan/project_size.h"

#include <algorithm>

#include "hybrid/model/view_part.h"
#include "relief/registration/search_pairs.h"

namespace relief {

namespace {

constexpr std::size_t kPairsPerView = 12;  // As bench/step_costs counts.

}  // namespace

ProjectSize size_of(const std::vector<RangeView>& views, bool ignore_poses) {
  ProjectSize size;
  size.views = views.size();
  for (const RangeView& view : views) {
    size.pixels += static_cast<double>(view.range.size());
    size.refined_pixels += static_cast<double>(hybrid::part_to_refine(view).pixels());
    size.samples += static_cast<double>(view.sample_count());
    size.search |= ignore_poses || view.pose == PoseKind::kAbsent;
    size.with_normals |= view.has_normals();
  }
  size.pairs = std::min(size.views * (size.views - std::min(size.views, std::size_t{1})) / 2,
                        kPairsPerView * size.views);
  size.first_pairs = std::min(size.pairs, registration::kFirstPairsPerView * size.views);
  return size;
}

}  // namespace relief
