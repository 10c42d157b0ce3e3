#include "scan/io/project/loading/cloud_viewpoints.h"

#include <algorithm>
#include <utility>

namespace relief {

namespace {

// Of the points that a view had on other rays, so many are on those from the origin: else they
// hide each other, and were not seen from there.
constexpr double kKept = 0.8;
// Of the normals, so many at most look away from the origin: all do of an object round it, and
// half of them where a program has not oriented them.
constexpr double kAverted = 0.75;

double averted_part(const LoadedView& loaded) {
  if (!loaded.normals) return 0.0;
  const Grid<Eigen::Vector3f>& normals = loaded.normals->components;
  std::size_t all = 0, averted = 0;
  for (int v = 0; v < normals.height(); ++v)
    for (int u = 0; u < normals.width(); ++u) {
      if (!normals(u, v).allFinite() || !loaded.view.has_sample(u, v)) continue;
      ++all;
      averted += normals(u, v).cast<double>().dot(loaded.view.point(u, v)) > 0.0 ? 1 : 0;
    }
  return all > 0 ? static_cast<double>(averted) / static_cast<double>(all) : 0.0;
}

}  // namespace

std::vector<std::size_t> views_to_see_from_origin(const std::vector<FoundSide>& sides) {
  const auto at_origin = std::ranges::count(sides, FoundSide::kOrigin);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (sides[i] == FoundSide::kFarOff) others.push_back(i);
  if (std::cmp_less_equal(at_origin, others.size())) others.clear();
  return others;
}

FoundSide side_in_set(const ViewSpec& spec, const LoadedView& loaded) {
  const bool other_frame = spec.grid_options.shared_frame ||
                           (spec.pose == PoseKind::kAbsent && loaded.view.pose != spec.pose);
  return other_frame ? FoundSide::kGiven : loaded.side;
}

bool see_from_origin(ViewSpec& spec, LoadedView& loaded) {
  ViewSpec other = spec;
  other.grid_options.viewpoint = Eigen::Vector3d::Zero();
  auto seen = load_view(other);
  if (!seen || averted_part(*seen) > kAverted ||
      static_cast<double>(seen->view.sample_count()) <
          kKept * static_cast<double>(loaded.view.sample_count()))
    return false;
  seen->side = FoundSide::kOrigin;
  seen->notes.push_back("view " + spec.name +
                        ": taken as seen from the origin of the frame, as most clouds of the set "
                        "are; alone it would be taken as seen from far off");
  spec = std::move(other);
  loaded = std::move(*seen);
  return true;
}

std::vector<std::string> settle_viewpoints(std::vector<ViewSpec>& specs) {
  std::vector<FoundSide> sides;
  for (const ViewSpec& spec : specs) {
    const bool asked = spec.grid && !spec.grid_options.viewpoint;
    const auto loaded = asked ? load_view(spec) : LoadedView();
    sides.push_back(asked && loaded ? side_in_set(spec, *loaded) : FoundSide::kGiven);
  }
  std::vector<std::string> notes;
  for (const std::size_t i : views_to_see_from_origin(sides)) {
    auto loaded = load_view(specs[i]);
    if (loaded && see_from_origin(specs[i], *loaded)) notes.push_back(loaded->notes.back());
  }
  return notes;
}

}  // namespace relief
