#include "registration/global/global_registration.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "registration/global/features/planar_view.h"
#include "registration/global/features/view_similarity.h"
#include "registration/global/link_limits.h"
#include "registration/global/pair_search.h"
#include "registration/global/turntable.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

constexpr std::size_t kSearchInFull = 300;  // Pairs of 25 views; bounds the time.

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

class GlobalRegistration {
 public:
  GlobalRegistration(const std::vector<ViewSurface>& surfaces, const ViewGroups& start,
                     const std::vector<bool>& known, const GlobalRegistrationOptions& options,
                     const Progress& progress, const AlignUnits& units)
      : surfaces_(surfaces),
        start_(start),
        known_(known),
        options_(options),
        progress_(progress),
        units_(units) {
    grouping_.limits = options.limits;
    grouping_.ambiguity = options.ambiguity;
    grouping_.judge.association = options.association;
  }

  Result<ViewGroups> run() {
    regroup();
    if (!complete() && !search_by_shape()) return interrupted();
    if (!complete()) {
      for (auto& link :
           turntable_links(surfaces_, groups_, options_.limits, options_.association)) {
        link.ambiguous = looks_repeated(link.a) || looks_repeated(link.b);
        links_.push_back(std::move(link));
      }
      regroup();
    }
    note_best_rejected();
    return std::move(groups_);
  }

 private:
  static Error interrupted() { return Error{ErrorKind::kInterrupted, "alignment was interrupted"}; }

  void regroup() { groups_ = join_views(surfaces_, links_, start_, known_, grouping_); }

  void note_best_rejected() {
    groups_.best_rejected.assign(surfaces_.size(), std::nullopt);
    for (const PoseLink& link : links_) {
      if (groups_.group[link.a] == groups_.group[link.b]) continue;
      for (const std::size_t i : {link.a, link.b}) {
        auto& most = groups_.best_rejected[i];
        if (!most || link.evidence.overlap > most->evidence.overlap) most = link;
      }
    }
  }

  // Whether all views that have samples are in one group.
  bool complete() const {
    std::optional<std::size_t> group;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
      if (surfaces_[i].samples().empty()) continue;
      if (group && *group != groups_.group[i]) return false;
      group = groups_.group[i];
    }
    return true;
  }

  // Most promising pairs first, in rounds; after each, the views that are joined are not searched
  // for one another any more.
  bool search_by_shape() {
    const CoarseScale scale = coarse_scale(surfaces_);
    std::vector<CoarseView> views(surfaces_.size());
    repeats_.assign(surfaces_.size(), std::nullopt);
    if (!go_on(0.0, "describing views")) return false;
    parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) views[i] = prepare_coarse_view(surfaces_[i], scale);
    });
    std::vector<const LocalFeatures*> features;
    for (const auto& view : views) features.push_back(&view.features);
    Pairs ranked = rank_pairs(features);
    const auto most = std::max(
        kSearchInFull, static_cast<std::size_t>(options_.pairs_per_view) * surfaces_.size());
    if (ranked.size() > most) ranked.resize(most);
    std::size_t next = 0;
    for (std::size_t round = 0; next < ranked.size() && !complete(); ++round) {
      // The first round is larger, for loops to confirm its links.
      const std::size_t wanted = (round == 0 ? 2 : 1) * surfaces_.size();
      Pairs batch;
      for (; next < ranked.size() && batch.size() < wanted; ++next)
        if (groups_.group[ranked[next].first] != groups_.group[ranked[next].second] &&
            views[ranked[next].first].points.size() > 0 &&
            views[ranked[next].second].points.size() > 0)
          batch.push_back(ranked[next]);
      if (!search(views, scale, batch,
                  static_cast<double>(next) / static_cast<double>(ranked.size())))
        return false;
      regroup();
    }
    return true;
  }

  bool search(const std::vector<CoarseView>& views, const CoarseScale& scale, const Pairs& pairs,
              double fraction) {
    PairSearchOptions options;
    options.association = options_.association;
    VerificationThresholds limits = options_.limits;
    limits.max_coherent_rms = std::max(limits.max_coherent_rms, grouping_.confirmed_coherent_rms);
    constexpr std::size_t kAtOnce = 8;  // Pairs side by side, between looks at go_on().
    for (std::size_t begin = 0; begin < pairs.size(); begin += kAtOnce) {
      if (!go_on(fraction, "comparing views")) return false;
      const std::size_t count = std::min(kAtOnce, pairs.size() - begin);
      std::vector<std::vector<PoseHypothesis>> found(count);
      parallel_for(count, 1, [&](std::size_t from, std::size_t to) {
        for (std::size_t k = from; k < to; ++k)
          found[k] = units_.search_pair(views, pairs[begin + k].first, pairs[begin + k].second,
                                        scale, options);
      });
      for (std::size_t k = 0; k < count; ++k) {
        const auto [a, b] = pairs[begin + k];
        std::erase_if(found[k], [&](const PoseHypothesis& hypothesis) {
          return !plausible(hypothesis.evidence, surfaces_[a], surfaces_[b], limits) &&
                 !may_be_right(hypothesis.evidence, surfaces_[a], surfaces_[b], options_.limits);
        });
        if (found[k].empty()) continue;
        const bool ambiguous = repeats_itself(a, views[a], scale, limits) ||
                               repeats_itself(b, views[b], scale, limits);
        for (const auto& hypothesis : found[k])
          links_.push_back({a, b, hypothesis.b_from_a, hypothesis.evidence, ambiguous});
      }
    }
    return true;
  }

  // Whether a view fits itself at a second place: so do then others that show the same shape, and
  // nothing tells at which. Views of flat faces alone fit others that show other faces.
  bool repeats_itself(std::size_t i, const CoarseView& view, const CoarseScale& scale,
                      const VerificationThresholds& limits) {
    if (!repeats_[i]) {
      VerificationThresholds alone = limits;
      alone.min_overlap = grouping_.lone_overlap;
      repeats_[i] = is_mostly_planar(surfaces_[i]) ||
                    units_.fits_itself(view, i, scale, alone, {options_.association, 150, 20});
    }
    return *repeats_[i];
  }

  // The same as far as it is known without a search.
  bool looks_repeated(std::size_t i) const {
    return i < repeats_.size() && repeats_[i] ? *repeats_[i] : is_mostly_planar(surfaces_[i]);
  }

  bool go_on(double fraction, std::string_view step) const {
    return report_progress(progress_, fraction, step);
  }

  const std::vector<ViewSurface>& surfaces_;
  const ViewGroups& start_;
  const std::vector<bool>& known_;
  const GlobalRegistrationOptions& options_;
  const Progress& progress_;
  const AlignUnits& units_;
  ViewGroupOptions grouping_;
  std::vector<PoseLink> links_;
  std::vector<std::optional<bool>> repeats_;  // Whether views fit themselves, where it matters.
  ViewGroups groups_;
};

}  // namespace

Result<ViewGroups> register_globally(const std::vector<ViewSurface>& surfaces,
                                     const ViewGroups& start, const std::vector<bool>& known,
                                     const GlobalRegistrationOptions& options,
                                     const Progress& progress, const AlignUnits& units) {
  assert(start.group.size() == surfaces.size() && known.size() == surfaces.size());
  return GlobalRegistration(surfaces, start, known, options, progress, units).run();
}

}  // namespace relief::registration
