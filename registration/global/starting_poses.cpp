#include "registration/global/starting_poses.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "registration/global/global_registration.h"
#include "registration/global/unplaced_reason.h"

namespace relief::registration {

namespace {

using Members = std::vector<std::size_t>;

GlobalRegistrationOptions place_options(const StartingPoseOptions& options) {
  GlobalRegistrationOptions place;
  place.association = options.association;
  place.limits.min_overlap = options.min_overlap;
  place.limits.max_free_space_violation = options.max_free_space_violation;
  return place;
}

// The groups that checked poses make. Their frame is the world; single views have their own.
ViewGroups groups_of(const CheckedPoses& checked) {
  ViewGroups groups = ViewGroups::singles(checked.group.size());
  groups.group = checked.group;
  for (std::size_t i = 0; i < checked.group.size(); ++i)
    if (checked.world_from_view[i]) groups.group_from_view[i] = *checked.world_from_view[i];
  return groups;
}

std::vector<Members> members_of(const ViewGroups& placed) {
  std::map<std::size_t, Members> by_first;
  for (std::size_t i = 0; i < placed.group.size(); ++i) by_first[placed.group[i]].push_back(i);
  std::vector<Members> groups;
  for (auto& [first, members] : by_first) groups.push_back(std::move(members));
  return groups;
}

// What a group has for being the main one, the most important first.
struct Rank {
  bool known = false;
  std::size_t size = 0;
  auto operator<=>(const Rank&) const = default;
};

Rank rank_of(const Members& members, const CheckedPoses& checked) {
  return {
      std::any_of(members.begin(), members.end(), [&](std::size_t i) { return checked.known[i]; }),
      members.size()};
}

// Given poses of the main group's views that hold among each other, after all else was found.
bool frame_is_trusted(const Members& main, const CheckedPoses& checked) {
  std::map<std::size_t, std::size_t> together;
  std::size_t given = 0, most = 0;
  for (const std::size_t i : main) {
    if (checked.known[i]) return true;
    if (!checked.world_from_view[i] && !checked.refuted[i]) continue;
    ++given;
    if (checked.world_from_view[i]) most = std::max(most, ++together[checked.group[i]]);
  }
  return given <= 1 || (most >= 2 && 2 * most >= given);
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
void place_component_beside(const Members& members, const std::vector<ViewSurface>& surfaces,
                            std::vector<Extent>& taken,
                            std::vector<std::optional<RigidMotion>>& poses) {
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

// Puts groups into the result: into the world where they hold checked poses, else beside.
class Assembly {
 public:
  Assembly(const std::vector<ViewSurface>& surfaces, const CheckedPoses& checked,
           const ViewGroups& placed, StartingPoses& result)
      : surfaces_(surfaces), checked_(checked), placed_(placed), result_(result) {}

  void run() {
    const auto groups = ordered_groups();
    if (groups.empty()) return;
    const Members& main = groups.front();
    const bool given = as_settled(main);
    if (main.size() == 1 && !given && surfaces_.size() > 1) return;
    put(main, frame_of(main), 0);
    const bool trusted = in_world(main) && frame_is_trusted(main, checked_);
    for (std::size_t g = 1; g < groups.size(); ++g) {
      // Poses that the user gave in one frame stay in it, confirmed or not, and what shape joined
      // to them.
      if (trusted && in_world(groups[g])) {
        put(groups[g], RigidMotion::Identity(), 0);
      } else if (groups[g].size() > 1) {
        put(groups[g], frame_of(groups[g]), g);
        place_component_beside(groups[g], surfaces_, taken_, result_.world_from_view);
      }
    }
    if (trusted) keep_what_fits_in_part();
  }

 private:
  void keep_what_fits_in_part() {
    for (std::size_t i = 0; i < checked_.fits_in_part.size(); ++i)
      if (!result_.world_from_view[i]) result_.world_from_view[i] = checked_.fits_in_part[i];
  }

  // The main group first. Views without samples are in none, unless they are known.
  std::vector<Members> ordered_groups() const {
    auto groups = members_of(placed_);
    for (Members& members : groups)
      std::erase_if(members, [&](std::size_t i) {
        return surfaces_[i].samples().empty() && !checked_.known[i];
      });
    std::erase_if(groups, [](const Members& members) { return members.empty(); });
    std::stable_sort(groups.begin(), groups.end(), [&](const Members& x, const Members& y) {
      return rank_of(x, checked_) > rank_of(y, checked_);
    });
    return groups;
  }

  // Whether the views of a group came together by checked poses alone.
  bool as_settled(const Members& members) const {
    return std::all_of(members.begin(), members.end(), [&](std::size_t i) {
      return checked_.world_from_view[i] && checked_.group[i] == checked_.group[members.front()];
    });
  }

  bool stayed(std::size_t i) const {
    return checked_.world_from_view[i] &&
           placed_.group_from_view[i].matrix() == checked_.world_from_view[i]->matrix();
  }

  // Whether the frame of a group is the world: some of its views stayed in it.
  bool in_world(const Members& members) const {
    return std::any_of(members.begin(), members.end(), [&](std::size_t i) { return stayed(i); });
  }

  // The world from the frame of a group.
  RigidMotion frame_of(const Members& members) const {
    if (in_world(members)) return RigidMotion::Identity();
    for (const std::size_t i : members)
      if (checked_.world_from_view[i])
        return *checked_.world_from_view[i] * placed_.group_from_view[i].inverse();
    return RigidMotion::Identity();
  }

  void put(const Members& members, const RigidMotion& world, std::size_t frame) {
    const bool moves = world.matrix() != RigidMotion::Identity().matrix();
    for (const std::size_t i : members) {
      result_.world_from_view[i] =
          moves ? world * placed_.group_from_view[i] : placed_.group_from_view[i];
      result_.frame[i] = frame;
      result_.found_by_shape[i] = !stayed(i);
    }
    if (frame == 0) taken_.push_back(extent_along_x(members, surfaces_, result_.world_from_view));
  }

  const std::vector<ViewSurface>& surfaces_;
  const CheckedPoses& checked_;
  const ViewGroups& placed_;
  StartingPoses& result_;
  std::vector<Extent> taken_;
};

void note_found_links(const ViewGroups& placed, const std::vector<RangeView>& views,
                      StartingPoses& result) {
  for (const PoseLink& link : placed.joined)
    result.notes.push_back("views " + views[link.a].name + " and " + views[link.b].name +
                           " were joined by their shape: overlap " +
                           in_percent(link.evidence.overlap));
}

// Whether all views with samples are in one group as they are.
bool all_together(const CheckedPoses& checked, const std::vector<ViewSurface>& surfaces) {
  std::optional<std::size_t> group;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (surfaces[i].samples().empty()) continue;
    if (!checked.world_from_view[i] || (group && *group != checked.group[i])) return false;
    group = checked.group[i];
  }
  return true;
}

bool looks_by_shape(const CheckedPoses& checked, const std::vector<ViewSurface>& surfaces,
                    const StartingPoseOptions& options) {
  return options.search && !all_together(checked, surfaces);
}

}  // namespace

Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const CheckedPoses& checked,
                                          const StartingPoseOptions& options,
                                          const Progress& progress, const AlignUnits& units) {
  ViewGroups placed = groups_of(checked);
  if (looks_by_shape(checked, surfaces, options)) {
    auto found =
        register_globally(surfaces, placed, checked.known, place_options(options), progress, units);
    if (!found) return found.error();
    placed = std::move(*found);
  }
  StartingPoses result;
  result.world_from_view.resize(views.size());
  result.frame.assign(views.size(), 0);
  result.found_by_shape.assign(views.size(), false);
  result.reasons.resize(views.size());
  Assembly(surfaces, checked, placed, result).run();
  for (std::size_t i = 0; i < views.size(); ++i) {
    result.kept.push_back(checked.kept[i] && !result.found_by_shape[i]);
    result.laid_on_plane.push_back(checked.laid_on_plane[i] && !result.found_by_shape[i]);
  }
  note_found_links(placed, views, result);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!result.world_from_view[i])
      result.reasons[i] = unplaced_reason(i, placed, checked, views, surfaces, options);
  return result;
}

Result<std::size_t> search_first_pairs(const std::vector<ViewSurface>& surfaces,
                                       const CheckedPoses& checked,
                                       const StartingPoseOptions& options, const PairBlock& block,
                                       const Progress& progress, const AlignUnits& units) {
  if (!looks_by_shape(checked, surfaces, options)) return std::size_t{0};
  return search_first_pairs(surfaces, groups_of(checked), checked.known, place_options(options),
                            block, progress, units);
}

}  // namespace relief::registration
