#include "registration/starting_poses.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>

#include "registration/coarse/place_views.h"

namespace relief {

namespace {

using Members = std::vector<std::size_t>;

std::vector<PosePrior> priors_of(const std::vector<RangeView>& views, CoarseSearch coarse) {
  std::vector<PosePrior> priors(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const bool known = views[i].pose == PoseKind::kKnown;
    const bool given = views[i].pose != PoseKind::kAbsent;
    if (known || (given && coarse != CoarseSearch::kAlways))
      priors[i].world_from_view = views[i].world_from_view;
    priors[i].known = known || (given && coarse == CoarseSearch::kNever);
  }
  return priors;
}

PlaceViewsOptions place_options(const StartingPoseOptions& options) {
  PlaceViewsOptions place;
  place.association = options.association;
  place.limits.min_overlap = options.min_overlap;
  place.limits.max_contradiction = options.max_contradiction;
  place.search = options.coarse != CoarseSearch::kNever;
  place.threads = options.threads;
  return place;
}

// Groups that hold views with known poses first, then by size, then by their first view. Single
// views are groups only when known, or when there is nothing else.
std::vector<Members> ordered_groups(const ViewGroups& placed, const std::vector<PosePrior>& priors,
                                    const std::vector<ViewSurface>& surfaces) {
  std::map<std::size_t, Members> by_first;
  for (std::size_t i = 0; i < placed.group.size(); ++i)
    if (!surfaces[i].samples().empty() || priors[i].known) by_first[placed.group[i]].push_back(i);
  std::vector<Members> groups;
  for (auto& [first, members] : by_first) groups.push_back(std::move(members));
  const auto known = [&](const Members& members) {
    return priors[members.front()].known ||
           std::any_of(members.begin(), members.end(),
                       [&](std::size_t i) { return priors[i].known; });
  };
  std::stable_sort(groups.begin(), groups.end(), [&](const Members& x, const Members& y) {
    return std::pair(known(x), x.size()) > std::pair(known(y), y.size());
  });
  const bool lonely = groups.size() == 1 && groups.front().size() == 1;
  std::erase_if(groups, [&](const Members& members) {
    return members.size() == 1 && !known(members) && !lonely;
  });
  return groups;
}

// Whether the views of a group came together by their given poses alone: these then stay.
bool as_given(const Members& members, const ViewGroups& placed,
              const std::vector<PosePrior>& priors) {
  const std::size_t group = placed.group[members.front()];
  return std::all_of(members.begin(), members.end(),
                     [&](std::size_t i) { return priors[i].world_from_view.has_value(); }) &&
         std::all_of(placed.joined.begin(), placed.joined.end(), [&](const PoseLink& link) {
           return placed.group[link.a] != group || link.given;
         });
}

RigidMotion world_from_group(const Members& members, const ViewGroups& placed,
                             const std::vector<PosePrior>& priors) {
  for (const std::size_t i : members)
    if (priors[i].known) return RigidMotion::Identity();
  for (const std::size_t i : members)
    if (priors[i].world_from_view)
      return *priors[i].world_from_view * placed.group_from_view[i].inverse();
  return RigidMotion::Identity();
}

// Along x, what the views of a group take up.
struct Extent {
  double low = 0.0, high = 0.0;
};

Extent extent_along_x(const Members& members, const std::vector<ViewSurface>& surfaces,
                      const std::vector<std::optional<RigidMotion>>& poses) {
  Extent extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const std::size_t i : members) {
    const double x = (*poses[i] * surfaces[i].centre()).x();
    extent.low = std::min(extent.low, x - surfaces[i].radius());
    extent.high = std::max(extent.high, x + surfaces[i].radius());
  }
  return extent;
}

// Groups are refined each in itself: they must not meet by chance.
void set_beside(const Members& members, const std::vector<ViewSurface>& surfaces,
                std::vector<Extent>& taken, std::vector<std::optional<RigidMotion>>& poses) {
  Extent own = extent_along_x(members, surfaces, poses);
  const double gap = own.high - own.low;
  const bool meets = std::any_of(taken.begin(), taken.end(), [&](const Extent& other) {
    return own.low - gap < other.high && other.low < own.high + gap;
  });
  if (meets) {
    double high = own.high;
    for (const Extent& other : taken) high = std::max(high, other.high);
    const double shift = high + 2.0 * gap - own.low;
    for (const std::size_t i : members)
      poses[i] = Eigen::Translation3d(shift, 0.0, 0.0) * *poses[i];
    own = {own.low + shift, own.high + shift};
  }
  taken.push_back(own);
}

void place_groups(const std::vector<Members>& groups, const ViewGroups& placed,
                  const std::vector<ViewSurface>& surfaces, const std::vector<PosePrior>& priors,
                  StartingPoses& result) {
  std::vector<Extent> taken;
  for (const Members& members : groups) {
    const bool given = as_given(members, placed, priors);
    const RigidMotion frame = world_from_group(members, placed, priors);
    for (const std::size_t i : members)
      result.world_from_view[i] =
          given || priors[i].known ? *priors[i].world_from_view : frame * placed.group_from_view[i];
    const bool fixed =
        std::any_of(members.begin(), members.end(), [&](std::size_t i) { return priors[i].known; });
    if (fixed)
      taken.push_back(extent_along_x(members, surfaces, result.world_from_view));
    else
      set_beside(members, surfaces, taken, result.world_from_view);
  }
}

std::string percent(double fraction) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f %%", 100.0 * fraction);
  return text;
}

void note_found_links(const ViewGroups& placed, const std::vector<RangeView>& views,
                      StartingPoses& result) {
  for (const PoseLink& link : placed.joined)
    if (!link.given)
      result.notes.push_back("views " + views[link.a].name + " and " + views[link.b].name +
                             " were joined by their shape: overlap " +
                             percent(link.evidence.overlap));
}

std::string reason_unplaced(std::size_t view, const ViewGroups& placed,
                            const std::vector<PosePrior>& priors,
                            const std::vector<RangeView>& views,
                            const StartingPoseOptions& options) {
  for (const AmbiguousPair& pair : placed.ambiguous) {
    if (placed.group[pair.a] != placed.group[view] && placed.group[pair.b] != placed.group[view])
      continue;
    const std::size_t other = placed.group[pair.a] == placed.group[view] ? pair.b : pair.a;
    return "it is ambiguous: it fits " + views[other].name + " in more ways than one (overlaps " +
           percent(pair.overlap) + " and " + percent(pair.second_overlap) +
           "), its shape is symmetric or too plain; give a guess in world_from_view";
  }
  const std::string given =
      priors[view].world_from_view ? "at its given pose it fits no other view, and " : "";
  if (options.coarse == CoarseSearch::kNever)
    return "it has no starting pose and none was found from its neighbours in scan order; give a "
           "guess in world_from_view";
  return given + "no pose was found at which it shares " + percent(options.min_overlap) +
         " with another view; add a view between or give a guess in world_from_view";
}

}  // namespace

Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const StartingPoseOptions& options,
                                          const Progress& progress) {
  const auto priors = priors_of(views, options.coarse);
  const auto placed = place_views(surfaces, priors, place_options(options), progress);
  if (!placed) return placed.error();
  StartingPoses result;
  result.world_from_view.resize(views.size());
  result.reasons.resize(views.size());
  const auto groups = ordered_groups(*placed, priors, surfaces);
  place_groups(groups, *placed, surfaces, priors, result);
  note_found_links(*placed, views, result);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!result.world_from_view[i])
      result.reasons[i] = reason_unplaced(i, *placed, priors, views, options);
  return result;
}

}  // namespace relief
