#include "scan/io/normals/convention_choice.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "scan/io/files/io_error.h"
#include "scan/io/normals/convention_notes.h"
#include "scan/io/normals/convention_scores.h"

namespace relief {

namespace {

// [rad], 35 deg: no error of a sensor, whose bias is 4 to 10 deg (docs/real-scans.md). Two
// unrelated normals of a visible half sphere have a mean cosine of (2/3)^2, 64 deg.
constexpr double kUnrelated = 0.611;
// [rad], 5 deg: two conventions that hardly differ in a view. For notes only.
constexpr double kSame = 0.087;

// Views whose normals are stored and declared alike.
bool alike(const NormalEvidence& a, const NormalEvidence& b) {
  return a.kind == b.kind && a.declared == b.declared && a.usual == b.usual;
}

// The mean angle between what two conventions make of the normals of a view [rad].
double angle_between(const NormalEvidence& view, const NormalConvention& a,
                     const NormalConvention& b) {
  const auto& patches = view.patches.patches;
  const Eigen::Matrix3d difference =
      view.view_from_stored(a).transpose() * view.view_from_stored(b);
  double sum = 0.0;
  for (const NormalPatch& patch : patches)
    sum += std::acos(std::clamp(patch.stored.dot(difference * patch.stored), -1.0, 1.0));
  return patches.empty() ? 0.0 : sum / static_cast<double>(patches.size());
}

int distance_to_usual(const NormalEvidence& view, const NormalConvention& convention) {
  int least = distance(view.usual.front(), convention);
  for (const NormalConvention& usual : view.usual)
    least = std::min(least, distance(usual, convention));
  return least;
}

// Of `left`, the one nearest to the usual ones; of equally near ones that which agrees best.
std::size_t nearest(const NormalEvidence& view, const std::vector<std::size_t>& left,
                    const ConventionRanking& ranking) {
  constexpr double kRounding = 1e-9;  // What rounding may make disagreements differ by.
  const auto& all = all_conventions(view.kind);
  std::size_t best = left.front();
  for (const std::size_t c : left) {
    const int nearer = distance_to_usual(view, all[best]) - distance_to_usual(view, all[c]);
    if (nearer > 0 ||
        (nearer == 0 && ranking.disagreement[c] < ranking.disagreement[best] - kRounding))
      best = c;
  }
  return best;
}

struct Decision {
  NormalConvention convention;
  bool certain = true;  // No other one fits that would make much of a difference.
};

Decision decide(const NormalEvidence& view, const ConventionRanking& of_all) {
  ConventionScores scores(view.kind);
  scores.add(view);
  const ConventionRanking alone = scores.ranking();
  std::vector<std::size_t> left;
  std::set_intersection(alone.candidates.begin(), alone.candidates.end(), of_all.candidates.begin(),
                        of_all.candidates.end(), std::back_inserter(left));
  const bool contradicts_others = left.empty();
  if (contradicts_others) left = alone.candidates;
  const auto& all = all_conventions(view.kind);
  Decision decision{all[nearest(view, left, contradicts_others ? alone : of_all)],
                    !view.patches.patches.empty() || left.size() == 1};
  for (const std::size_t c : left)
    if (angle_between(view, all[c], decision.convention) > kSame) decision.certain = false;
  return decision;
}

struct Settled {
  ChosenConvention chosen;
  double bias = 0.0;      // [rad]
  bool compared = false;  // With enough of the depth.

  bool is_unrelated(const NormalEvidence& view) const {
    return bias > kUnrelated && view.kind == NormalFileKind::kImage;
  }
};

Settled settle(const NormalEvidence& view, const ConventionRanking& of_all,
               ConventionNotes& notes) {
  const Decision decision = decide(view, of_all);
  Settled settled;
  settled.chosen.convention = decision.convention;
  settled.compared = view.patches.patches.size() >= kFewestPatches;
  if (settled.compared) settled.bias = agreement(view, decision.convention).bias;
  settled.chosen.usable = !(settled.bias > kLargestBias);
  if (settled.chosen.usable) {
    notes.add_choice(view, decision.convention, decision.certain);
    if (view.curve != TransferCurve::kNone) notes.add_curve(view);
  } else if (!settled.is_unrelated(view)) {
    notes.add_unusable(view, decision.convention, settled.bias);
  }
  return settled;
}

// A normal map that fits the depth of its view in no convention.
struct UnrelatedMap {
  std::size_t view = 0;  // Index into the evidence of all views.
  NormalConvention best;
  double bias = 0.0;  // In the best convention [rad].
};

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
std::optional<std::size_t> view_that_fits(const UnrelatedMap& map,
                                          const std::vector<NormalEvidence>& views,
                                          const std::vector<ChosenConvention>& chosen) {
  std::optional<std::size_t> best;
  double least = kLargestBias;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i == map.view || views[i].kind != views[map.view].kind) continue;
    const NormalEvidence both = with_depth_of_other(views[map.view], views[i]);
    if (both.patches.patches.size() < kFewestPatches) continue;
    const double bias = agreement(both, chosen[i].convention).bias;
    if (!(bias < least)) continue;
    least = bias;
    best = i;
  }
  return best;
}

std::string fit_text(const UnrelatedMap& map, const std::vector<NormalEvidence>& views,
                     const std::vector<ChosenConvention>& chosen) {
  const auto other = view_that_fits(map, views, chosen);
  return other ? ", but fits the depth of view " + views[*other].view : std::string();
}

Error unrelated_error(const std::vector<UnrelatedMap>& unrelated, std::size_t maps,
                      const std::vector<NormalEvidence>& views,
                      const std::vector<ChosenConvention>& chosen) {
  const UnrelatedMap& first = unrelated.front();
  const NormalEvidence& view = views[first.view];
  const std::string others = unrelated.size() > 1
                                 ? "; " + std::to_string(unrelated.size()) + " of " +
                                       std::to_string(maps) + " maps are as far off"
                                 : std::string();
  return bad_input(view.file, "no convention of normals fits the depth of view " + view.view +
                                  ": the best, " + name_of(view, first.best) + ", is off by " +
                                  degrees_text(first.bias) + " (median)" +
                                  fit_text(first, views, chosen) + others +
                                  "; check that the file belongs to this view and that scale and "
                                  "camera are right, or take `normals` out of the view");
}

std::string unrelated_warning(const std::vector<UnrelatedMap>& unrelated, std::size_t maps,
                              const std::vector<NormalEvidence>& views,
                              const std::vector<ChosenConvention>& chosen) {
  constexpr std::size_t kNamed = 20;
  std::string text = "warning: " + std::to_string(unrelated.size()) + " of " +
                     std::to_string(maps) + " normal maps " +
                     (unrelated.size() > 1 ? "are" : "is") +
                     " not used, as no convention fits the depth of the view: ";
  for (std::size_t i = 0; i < std::min(kNamed, unrelated.size()); ++i) {
    const NormalEvidence& view = views[unrelated[i].view];
    text += (i > 0 ? "; " : "") + view.file.string() + " of view " + view.view + " is off by " +
            degrees_text(unrelated[i].bias) + " (median)" + fit_text(unrelated[i], views, chosen);
  }
  if (unrelated.size() > kNamed) text += "; and more";
  return text;
}

// Maps of other views are left out where at least as many maps fit. Else something else is wrong,
// as the scale of all depths.
Result<void> judge_unrelated(const std::vector<NormalEvidence>& views,
                             const std::vector<Settled>& settled, ConventionChoice& choice) {
  std::vector<UnrelatedMap> unrelated;
  std::size_t compared = 0, fitting = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!settled[i].compared || views[i].kind != NormalFileKind::kImage) continue;
    ++compared;
    fitting += settled[i].chosen.usable ? 1 : 0;
    if (settled[i].is_unrelated(views[i]))
      unrelated.push_back({i, settled[i].chosen.convention, settled[i].bias});
  }
  if (unrelated.empty()) return {};
  if (unrelated.size() > fitting) return unrelated_error(unrelated, compared, views, choice.views);
  choice.notes.push_back(unrelated_warning(unrelated, compared, views, choice.views));
  return {};
}

}  // namespace

Result<ConventionChoice> choose_conventions(const std::vector<NormalEvidence>& views) {
  ConventionChoice choice;
  choice.views.resize(views.size());
  std::vector<Settled> settled(views.size());
  std::vector<bool> done(views.size(), false);
  ConventionNotes notes;
  for (std::size_t first = 0; first < views.size(); ++first) {
    if (done[first]) continue;
    std::vector<std::size_t> group;
    ConventionScores scores(views[first].kind);
    for (std::size_t i = first; i < views.size(); ++i) {
      if (!alike(views[first], views[i])) continue;
      group.push_back(i);
      scores.add(views[i]);
    }
    const ConventionRanking of_all = scores.ranking();  // The same for all: made once.
    for (const std::size_t i : group) {
      done[i] = true;
      settled[i] = settle(views[i], of_all, notes);
      choice.views[i] = settled[i].chosen;
    }
  }
  choice.notes = notes.texts(views.size());
  if (const auto judged = judge_unrelated(views, settled, choice); !judged) return judged.error();
  return choice;
}

}  // namespace relief
