#include "scan/io/normals/foreign_maps.h"

#include <algorithm>
#include <iterator>
#include <numbers>

#include "scan/io/files/io_error.h"
#include "scan/io/normals/convention_notes.h"

namespace relief {

namespace {

// The normals of `map` beside the depth of another view, where both have a patch. Lattices may
// differ in their step.
NormalEvidence with_depth_of_other(const NormalEvidence& map, const NormalEvidence& other) {
  NormalEvidence both = other;
  both.patches.patches.clear();
  const Grid<int>&of_map = map.patches.lattice, &of_other = other.patches.lattice;
  const auto place = [&](int of_other_lattice) {
    const int step = other.patches.step, middle = of_other_lattice * step + step / 2;
    return middle / map.patches.step;
  };
  for (int row = 0; row < of_other.height(); ++row) {
    for (int column = 0; column < of_other.width(); ++column) {
      const int u = place(column), v = place(row);
      if (of_other(column, row) < 0 || !of_map.contains(u, v) || of_map(u, v) < 0) continue;
      both.patches.patches.push_back(
          other.patches.patches[static_cast<std::size_t>(of_other(column, row))]);
      both.patches.patches.back().stored =
          map.patches.patches[static_cast<std::size_t>(of_map(u, v))].stored;
    }
  }
  return both;
}

constexpr double kAnyAngle = std::numbers::pi;  // [rad]

// The conventions of the maps that fit their own depth; without any, the usual ones.
std::vector<NormalConvention> conventions_of_set(const std::vector<NormalEvidence>& views,
                                                 const std::vector<SettledNormals>& settled,
                                                 const NormalEvidence& map) {
  std::vector<NormalConvention> all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ChosenConvention& chosen = settled[i].chosen;
    if (settled[i].compared && chosen.usable && views[i].kind == map.kind &&
        std::ranges::find(all, chosen.convention) == all.end())
      all.push_back(chosen.convention);
  }
  return all.empty() ? map.usual : all;
}

// The view whose depth a map fits instead: the one that it is closest to, within the bias of a
// sensor and half its distance from its own depth, and closer than to its own where it lies wrong.
std::optional<std::size_t> view_that_fits(std::size_t map, const std::vector<NormalEvidence>& views,
                                          const std::vector<SettledNormals>& settled) {
  const auto conventions = conventions_of_set(views, settled, views[map]);
  std::optional<std::size_t> best;
  const auto& placement = views[map].placement;
  const double on_its_own = placement ? placement->median : kAnyAngle;
  double least = std::min(kLargestBias, 0.5 * settled[map].bias);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i == map || views[i].kind != views[map].kind) continue;
    const NormalEvidence both = with_depth_of_other(views[map], views[i]);
    if (both.patches.patches.size() < kFewestPatches) continue;
    for (const NormalConvention& convention : conventions) {
      if (!both.possible(convention)) continue;
      const NormalAgreement found = agreement(both, convention);
      if (!(found.bias < least && found.median < on_its_own)) continue;
      least = found.bias;
      best = i;
    }
  }
  return best;
}

std::string fit_text(const ForeignMap& map, const std::vector<NormalEvidence>& views) {
  if (map.other) return ", but fits the depth of view " + views[*map.other].view;
  const auto& placement = views[map.view].placement;
  return placement
             ? ", but fits it " + to_string(*placement) + ", to " + degrees_text(placement->median)
             : std::string();
}

Error foreign_error(const std::vector<ForeignMap>& far_off, std::size_t maps,
                    const std::vector<NormalEvidence>& views,
                    const std::vector<SettledNormals>& settled) {
  const ForeignMap& first = far_off.front();
  const NormalEvidence& view = views[first.view];
  const SettledNormals& best = settled[first.view];
  const std::string others = far_off.size() > 1 ? "; " + std::to_string(far_off.size()) + " of " +
                                                      std::to_string(maps) + " maps are as far off"
                                                : std::string();
  return bad_input(view.file, "no convention of normals fits the depth of view " + view.view +
                                  ": the best, " + name_of(view, best.chosen.convention) +
                                  ", is off by " + degrees_text(best.bias) + " (median)" +
                                  fit_text(first, views) + others +
                                  "; check that the file belongs to this view and that scale and "
                                  "camera are right, or take `normals` out of the view");
}

std::string foreign_warning(const std::vector<ForeignMap>& foreign, std::size_t maps,
                            const std::vector<NormalEvidence>& views,
                            const std::vector<SettledNormals>& settled) {
  constexpr std::size_t kNamed = 8;
  std::string text = "warning: " + std::to_string(foreign.size()) + " of " + std::to_string(maps) +
                     " normal maps " + (foreign.size() > 1 ? "are" : "is") +
                     " not used, as no convention fits the depth of the view: ";
  for (std::size_t i = 0; i < std::min(kNamed, foreign.size()); ++i) {
    const NormalEvidence& view = views[foreign[i].view];
    text += (i > 0 ? "; " : "") + view.file.string() + " of view " + view.view + " is off by " +
            degrees_text(settled[foreign[i].view].bias) + " (median)" + fit_text(foreign[i], views);
  }
  if (foreign.size() > kNamed) text += "; and " + std::to_string(foreign.size() - kNamed) + " more";
  return text;
}

}  // namespace

std::vector<ForeignMap> find_foreign_maps(const std::vector<NormalEvidence>& views,
                                          const std::vector<SettledNormals>& settled) {
  std::vector<ForeignMap> foreign;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].kind != NormalFileKind::kImage || settled[i].chosen.usable) continue;
    const auto other = view_that_fits(i, views, settled);
    if (other || views[i].placement || settled[i].bias > kUnrelatedBias)
      foreign.push_back({i, other});
  }
  return foreign;
}

Result<std::string> judge_foreign_maps(const std::vector<ForeignMap>& foreign,
                                       const std::vector<NormalEvidence>& views,
                                       const std::vector<SettledNormals>& settled) {
  std::size_t maps = 0, fitting = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!settled[i].compared || views[i].kind != NormalFileKind::kImage) continue;
    ++maps;
    fitting += settled[i].chosen.usable ? 1 : 0;
  }
  std::vector<ForeignMap> far_off;
  std::ranges::copy_if(foreign, std::back_inserter(far_off), [&](const ForeignMap& map) {
    return settled[map.view].bias > kUnrelatedBias;
  });
  if (far_off.size() > fitting) return foreign_error(far_off, maps, views, settled);
  return foreign_warning(foreign, maps, views, settled);
}

}  // namespace relief
