#include "scan/io/normals/foreign_maps.h"

#include <algorithm>
#include <iterator>

#include "scan/io/files/io_error.h"
#include "scan/io/normals/convention_notes.h"

namespace relief {

namespace {

// The normals of `map` beside the depth of another view, where both have a patch. Patches of
// lattices that differ in size lie elsewhere.
NormalEvidence with_depth_of_other(const NormalEvidence& map, const NormalEvidence& other) {
  NormalEvidence both = other;
  both.patches.patches.clear();
  const Grid<int>&of_map = map.patches.lattice, &of_other = other.patches.lattice;
  if (of_map.width() != of_other.width() || of_map.height() != of_other.height()) return both;
  for (std::size_t i = 0; i < of_map.size(); ++i) {
    if (of_map[i] < 0 || of_other[i] < 0) continue;
    both.patches.patches.push_back(other.patches.patches[static_cast<std::size_t>(of_other[i])]);
    both.patches.patches.back().stored =
        map.patches.patches[static_cast<std::size_t>(of_map[i])].stored;
  }
  return both;
}

// The view whose depth a map fits instead: the one that it is closest to, within the bias of a
// sensor.
std::optional<std::size_t> view_that_fits(std::size_t map, const std::vector<NormalEvidence>& views,
                                          const std::vector<SettledNormals>& settled) {
  std::optional<std::size_t> best;
  double least = kLargestBias;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i == map || views[i].kind != views[map].kind) continue;
    const NormalEvidence both = with_depth_of_other(views[map], views[i]);
    if (both.patches.patches.size() < kFewestPatches) continue;
    const double bias = agreement(both, settled[i].chosen.convention).bias;
    if (!(bias < least)) continue;
    least = bias;
    best = i;
  }
  return best;
}

std::string fit_text(const ForeignMap& map, const std::vector<NormalEvidence>& views) {
  return map.other ? ", but fits the depth of view " + views[*map.other].view : std::string();
}

Error foreign_error(const std::vector<ForeignMap>& far_off, std::size_t maps,
                    const std::vector<NormalEvidence>& views,
                    const std::vector<SettledNormals>& settled) {
  const ForeignMap& first = far_off.front();
  const NormalEvidence& view = views[first.view];
  const SettledNormals& best = settled[first.view];
  const std::string others = far_off.size() > 1
                                 ? "; " + std::to_string(far_off.size()) + " of " +
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
  constexpr std::size_t kNamed = 20;
  std::string text = "warning: " + std::to_string(foreign.size()) + " of " + std::to_string(maps) +
                     " normal maps " + (foreign.size() > 1 ? "are" : "is") +
                     " not used, as no convention fits the depth of the view: ";
  for (std::size_t i = 0; i < std::min(kNamed, foreign.size()); ++i) {
    const NormalEvidence& view = views[foreign[i].view];
    text += (i > 0 ? "; " : "") + view.file.string() + " of view " + view.view + " is off by " +
            degrees_text(settled[foreign[i].view].bias) + " (median)" +
            fit_text(foreign[i], views);
  }
  if (foreign.size() > kNamed) text += "; and more";
  return text;
}

}  // namespace

std::vector<ForeignMap> find_foreign_maps(const std::vector<NormalEvidence>& views,
                                          const std::vector<SettledNormals>& settled) {
  std::vector<ForeignMap> foreign;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].kind == NormalFileKind::kImage && settled[i].bias > kUnrelatedBias)
      foreign.push_back({i, view_that_fits(i, views, settled)});
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
