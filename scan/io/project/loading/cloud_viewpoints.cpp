#include "scan/io/project/loading/cloud_viewpoints.h"

#include <algorithm>
#include <utility>

#include "scan/io/project/scan_file.h"

namespace relief {

namespace {

// Of the points that a view had on other rays, so many are on those from the origin: else they
// hide each other, and were not seen from there.
constexpr double kKept = 0.8;

bool is_cloud_without_viewpoint(const ViewSpec& spec) {
  return spec.grid && !spec.grid_options.viewpoint && !spec.camera &&
         kind_of_scan_file(*spec.grid) == ScanFileKind::kPoints;
}

}  // namespace

std::vector<std::size_t> views_to_see_from_origin(const std::vector<FoundSide>& sides) {
  const auto at_origin = std::ranges::count(sides, FoundSide::kOrigin);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (sides[i] == FoundSide::kFarOff) others.push_back(i);
  if (at_origin == 0 || std::cmp_less(at_origin, others.size())) others.clear();
  return others;
}

bool see_from_origin(ViewSpec& spec, LoadedView& loaded) {
  ViewSpec other = spec;
  other.grid_options.viewpoint = Eigen::Vector3d::Zero();
  auto seen = load_view(other);
  if (!seen || static_cast<double>(seen->view.sample_count()) <
                   kKept * static_cast<double>(loaded.view.sample_count()))
    return false;
  seen->side = FoundSide::kOrigin;
  seen->notes.push_back("view " + spec.name +
                        ": taken as seen from the origin of the frame, as other clouds of the set "
                        "are; alone it would be taken as seen from far off");
  spec = std::move(other);
  loaded = std::move(*seen);
  return true;
}

void settle_viewpoints(std::vector<ViewSpec>& specs) {
  std::vector<FoundSide> sides;
  for (const ViewSpec& spec : specs) {
    const auto loaded = is_cloud_without_viewpoint(spec) ? load_view(spec) : LoadedView();
    sides.push_back(loaded ? loaded->side : FoundSide::kGiven);
  }
  for (const std::size_t i : views_to_see_from_origin(sides))
    if (auto loaded = load_view(specs[i])) see_from_origin(specs[i], *loaded);
}

}  // namespace relief
