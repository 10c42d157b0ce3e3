#include "scan/io/normals/convention_choice.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "scan/base/name_list.h"
#include "scan/io/normals/consensus_sets.h"
#include "scan/io/normals/convention_notes.h"
#include "scan/io/normals/convention_scores.h"
#include "scan/io/normals/foreign_maps.h"

namespace relief {

namespace {

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

// `of_set`: what the view says together with those that agree with it.
Decision decide(const NormalEvidence& view, const ConventionRanking& alone,
                const ConventionRanking& of_set) {
  std::vector<std::size_t> left;
  std::ranges::set_intersection(alone.candidates, of_set.candidates, std::back_inserter(left));
  const bool contradicts_others = left.empty();
  if (contradicts_others) left = alone.candidates;
  const auto& all = all_conventions(view.kind);
  Decision decision{all[nearest(view, left, contradicts_others ? alone : of_set)],
                    !view.patches.patches.empty() || left.size() == 1};
  for (const std::size_t c : left)
    if (angle_between(view, all[c], decision.convention) > kSame) decision.certain = false;
  return decision;
}

SettledNormals settle(const NormalEvidence& view, const Decision& decision) {
  SettledNormals settled;
  settled.chosen.convention = decision.convention;
  settled.certain = decision.certain;
  settled.compared = view.patches.patches.size() >= kFewestPatches;
  if (settled.compared) settled.bias = agreement(view, decision.convention).bias;
  settled.chosen.usable = !(settled.bias > kLargestBias);
  return settled;
}

// Views that are declared alike, by their indices among all.
using Group = std::vector<std::size_t>;

// Maps that lie wrong on their depth have no part in it.
std::vector<Group> find_groups(const std::vector<NormalEvidence>& views) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].placement) continue;
    const auto found = std::ranges::find_if(
        groups, [&](const Group& group) { return alike(views[group.front()], views[i]); });
    if (found != groups.end())
      found->push_back(i);
    else
      groups.push_back({i});
  }
  return groups;
}

SettledNormals settle_misplaced(const NormalEvidence& view) {
  const ConventionRanking alone = rank_alone(view);
  SettledNormals settled = settle(view, decide(view, alone, alone));
  settled.chosen.usable = false;
  return settled;
}

// Whether a view could follow the convention of another view of its group as well.
bool is_torn(std::size_t view, const ConventionRanking& alone, const Group& group,
             const std::vector<NormalEvidence>& views, const std::vector<SettledNormals>& settled) {
  const auto& all = all_conventions(views[view].kind);
  return std::ranges::any_of(group, [&](std::size_t other) {
    const ChosenConvention& of_other = settled[other].chosen;
    return of_other.usable &&
           std::ranges::any_of(alone.candidates,
                               [&](std::size_t c) { return all[c] == of_other.convention; }) &&
           angle_between(views[view], of_other.convention, settled[view].chosen.convention) > kSame;
  });
}

// True if the views agree on one convention.
bool settle_group(const Group& group, const std::vector<NormalEvidence>& views,
                  std::vector<SettledNormals>& settled) {
  std::vector<ConventionRanking> alone;
  for (const std::size_t view : group) alone.push_back(rank_alone(views[view]));
  const std::vector<ConsensusSet> sets = find_consensus_sets(alone);
  for (const ConsensusSet& set : sets) {
    ConventionScores scores(views[group.front()].kind);
    for (const std::size_t member : set) scores.add(views[group[member]]);
    const ConventionRanking of_set = scores.ranking();  // The same for all: made once.
    for (const std::size_t member : set)
      settled[group[member]] =
          settle(views[group[member]], decide(views[group[member]], alone[member], of_set));
  }
  if (sets.size() == 1) return true;
  for (std::size_t member = 0; member < group.size(); ++member)
    if (is_torn(group[member], alone[member], group, views, settled))
      settled[group[member]].certain = false;
  return false;
}

// Names the views whose convention is not that of the most.
std::optional<std::string> note_on_mixture(const Group& group,
                                           const std::vector<NormalEvidence>& views,
                                           const std::vector<SettledNormals>& settled) {
  std::vector<NormalConvention> used;
  for (const std::size_t view : group)
    if (settled[view].chosen.usable) used.push_back(settled[view].chosen.convention);
  const auto uses = [&](const NormalConvention& c) { return std::ranges::count(used, c); };
  if (used.empty() || uses(used.front()) == std::ssize(used)) return std::nullopt;
  const NormalConvention most = *std::ranges::max_element(used, {}, uses);
  std::vector<std::string> others;
  for (const std::size_t view : group) {
    const ChosenConvention& chosen = settled[view].chosen;
    if (chosen.usable && chosen.convention != most) others.push_back(views[view].view);
  }
  return "warning: not all normals are of one convention: those of " +
         std::to_string(others.size()) + " of " + std::to_string(used.size()) +
         " views differ from the others, as the depth of these views shows (" + name_list(others) +
         "); each is used in its own; check how the files were written";
}

void add_notes(const NormalEvidence& view, const SettledNormals& settled, ConventionNotes& notes) {
  if (!settled.chosen.usable)
    return notes.add_unusable(view, settled.chosen.convention, settled.bias);
  notes.add_choice(view, settled.chosen.convention, settled.certain);
  if (view.curve != TransferCurve::kNone) notes.add_curve(view);
}

}  // namespace

Result<ConventionChoice> choose_conventions(const std::vector<NormalEvidence>& views) {
  const std::vector<Group> groups = find_groups(views);
  std::vector<SettledNormals> settled(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    if (views[i].placement) settled[i] = settle_misplaced(views[i]);
  std::vector<std::string> mixtures;
  for (const Group& group : groups) {
    const bool agree = settle_group(group, views, settled);
    // Of declared ones the notes say already which differ.
    if (agree || views[group.front()].declared) continue;
    if (auto note = note_on_mixture(group, views, settled)) mixtures.push_back(std::move(*note));
  }
  const std::vector<ForeignMap> foreign = find_foreign_maps(views, settled);
  ConventionNotes notes;
  for (const Group& group : groups)
    for (const std::size_t view : group)
      if (!std::ranges::binary_search(foreign, view, {}, &ForeignMap::view))
        add_notes(views[view], settled[view], notes);

  ConventionChoice choice;
  for (const SettledNormals& one : settled) choice.views.push_back(one.chosen);
  choice.notes = notes.texts(views.size());
  choice.notes.insert(choice.notes.end(), mixtures.begin(), mixtures.end());
  if (foreign.empty()) return choice;
  if (const auto judged = judge_foreign_maps(foreign, views, settled); !judged)
    return judged.error();
  else
    choice.notes.push_back(*judged);
  return choice;
}

}  // namespace relief
