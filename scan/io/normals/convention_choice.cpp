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
constexpr std::size_t kFewestPatches = 8;

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

Error unrelated(const NormalEvidence& view, const NormalConvention& best, double angle) {
  return bad_input(view.file, "no convention of normals fits the depth of view " + view.view +
                                  ": the best, " + name_of(view, best) + ", is off by " +
                                  degrees_text(angle) +
                                  " (median); check that the file belongs to this view and that "
                                  "scale and camera are right, or take `normals` out of the view");
}

Result<ChosenConvention> settle(const NormalEvidence& view, const ConventionRanking& of_all,
                                ConventionNotes& notes) {
  const Decision decision = decide(view, of_all);
  ChosenConvention chosen{decision.convention, true};
  if (view.patches.patches.size() >= kFewestPatches) {
    const double bias = agreement(view, decision.convention).bias;
    if (bias > kUnrelated && view.kind == NormalFileKind::kImage)
      return unrelated(view, decision.convention, bias);
    chosen.usable = !(bias > kLargestBias);
    if (!chosen.usable) notes.add_unusable(view, decision.convention, bias);
  }
  if (chosen.usable) notes.add_choice(view, decision.convention, decision.certain);
  return chosen;
}

}  // namespace

Result<ConventionChoice> choose_conventions(const std::vector<NormalEvidence>& views) {
  ConventionChoice choice;
  choice.views.resize(views.size());
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
      const auto chosen = settle(views[i], of_all, notes);
      if (!chosen) return chosen.error();
      choice.views[i] = *chosen;
    }
  }
  choice.notes = notes.texts(views.size());
  return choice;
}

}  // namespace relief
