#include "registration/global/global_registration.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <utility>

#include "registration/global/features/planar_view.h"
#include "registration/global/features/view_similarity.h"
#include "registration/global/judged_pairs.h"
#include "registration/global/links/best_rejected_poses.h"
#include "registration/global/links/link_limits.h"
#include "registration/global/links/pair_links.h"
#include "registration/global/pair_search.h"
#include "registration/global/turntable.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

constexpr std::size_t kSearchInFull = 300;  // Pairs of 25 views; bounds the time.

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

class GlobalRegistration {
 public:
  GlobalRegistration(const std::vector<ViewSurface>& whole, const ViewGroups& start,
                     const std::vector<bool>& known, const GlobalRegistrationOptions& options,
                     const Progress& progress, const AlignUnits& units)
      : parts_(without_dominant_planes(whole)),
        surfaces_(parts_.empty() ? whole : parts_),
        start_(start),
        known_(known),
        options_(options),
        progress_(progress),
        units_(units),
        judged_(surfaces_),
        pair_links_(surfaces_, whole, grouping_),
        best_rejected_(surfaces_, options.limits),
        denied_by_plane_(whole.size(), false) {
    grouping_.limits = options.limits;
    grouping_.ambiguity = options.ambiguity;
    grouping_.judge.association = options.association;
  }

  Result<ViewGroups> run() {
    regroup();
    if (!complete() && !search_by_shape()) return interrupted();
    if (!complete()) {
      for (const auto& link :
           turntable_links(surfaces_, groups_, options_.limits, grouping_.judge)) {
        std::vector<PoseHypothesis> found{{link.b_from_a, link.evidence}};
        keep_candidates(link.a, link.b, found);
        add_links(pair_links_.of_pair(link.a, link.b, found, scale_));
      }
      regroup();
    }
    groups_.best_rejected = best_rejected_.between_groups(groups_.group, links_);
    groups_.denied_by_plane = std::move(denied_by_plane_);
    return std::move(groups_);
  }

  Result<std::size_t> search_first(const PairBlock& block) {
    regroup();
    if (complete()) return std::size_t{0};
    if (!describe_views()) return interrupted();
    const Pairs pairs = next_round(0);
    Pairs own;
    for (std::size_t k = block.index; k < pairs.size(); k += block.count) own.push_back(pairs[k]);
    std::vector<std::size_t> own_views;
    for (std::size_t i = block.index; i < views_.size(); i += block.count)
      if (has_points(i)) own_views.push_back(i);
    if (!hypotheses_of(own) || !find_symmetries(own_views)) return interrupted();
    return own.size();
  }

 private:
  static Error interrupted() { return Error{ErrorKind::kInterrupted, "alignment was interrupted"}; }

  void regroup() { groups_ = join_views(surfaces_, links_, start_, known_, grouping_, judged_); }

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
    if (!describe_views() || !link_known_pairs()) return false;
    for (std::size_t round = 0; next_ < ranked_.size() && !complete(); ++round) {
      if (!search(next_round(round))) return false;
      regroup();
    }
    return true;
  }

  bool describe_views() {
    scale_ = coarse_scale(surfaces_);
    views_.resize(surfaces_.size());
    if (!go_on("describing views")) return false;
    parallel_for(views_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        views_[i] = prepare_coarse_view(surfaces_[i], scale_);
    });
    pair_links_.find_faces();
    std::vector<const LocalFeatures*> features;
    for (const auto& view : views_) features.push_back(&view.features);
    ranked_ = rank_pairs(features);
    const auto most = std::max(
        kSearchInFull, static_cast<std::size_t>(options_.pairs_per_view) * surfaces_.size());
    if (ranked_.size() > most) ranked_.resize(most);
    return true;
  }

  Pairs next_round(std::size_t round) {
    // The first round is larger, for loops to confirm its links.
    const std::size_t wanted = (round == 0 ? kFirstPairsPerView : 1) * surfaces_.size();
    Pairs pairs;
    for (; next_ < ranked_.size() && pairs.size() < wanted; ++next_) {
      const auto [a, b] = ranked_[next_];
      if (groups_.group[a] != groups_.group[b] && has_points(a) && has_points(b))
        pairs.push_back(ranked_[next_]);
    }
    return pairs;
  }

  // Of views whose poses are known, the most promising pairs. They tell what errors the views have,
  // and close loops with links to other views. False when asked to stop.
  bool link_known_pairs() {
    Pairs pairs;
    for (const auto& [a, b] : ranked_)
      if (start_.group[a] == start_.group[b] && has_points(a) && has_points(b) &&
          pairs.size() < kFirstPairsPerView * views_.size())
        pairs.emplace_back(a, b);
    std::vector<std::optional<PoseHypothesis>> found(pairs.size());
    const bool done = for_each(pairs.size(), "comparing views", [&](std::size_t k) {
      const auto [a, b] = pairs[k];
      found[k] = confirm_pose(surfaces_[a], surfaces_[b],
                              start_.group_from_view[b].inverse() * start_.group_from_view[a],
                              scale_, grouping_.judge);
    });
    for (std::size_t k = 0; k < pairs.size(); ++k)
      if (found[k] && found[k]->evidence.overlap >= options_.limits.min_overlap)
        known_links_.push_back(
            {pairs[k].first, pairs[k].second, found[k]->b_from_a, found[k]->evidence});
    add_links(known_links_);
    return done;
  }

  bool has_points(std::size_t i) const { return views_[i].points.size() > 0; }

  // Calls `work` with 0 .. count - 1, side by side. False when asked to stop.
  bool for_each(std::size_t count, std::string_view step,
                const std::function<void(std::size_t)>& work) const {
    constexpr std::size_t kAtOnce = 8;  // Between looks at go_on().
    for (std::size_t begin = 0; begin < count; begin += kAtOnce) {
      if (!go_on(step)) return false;
      parallel_for(std::min(kAtOnce, count - begin), 1, [&](std::size_t from, std::size_t to) {
        for (std::size_t k = from; k < to; ++k) work(begin + k);
      });
    }
    return true;
  }

  using Hypotheses = std::vector<std::vector<PoseHypothesis>>;  // By pair.

  // Of pairs; nothing when asked to stop.
  std::optional<Hypotheses> hypotheses_of(const Pairs& pairs) const {
    PairSearchOptions options;
    options.judge = grouping_.judge;
    Hypotheses found(pairs.size());
    const bool done = for_each(pairs.size(), "comparing views", [&](std::size_t k) {
      found[k] = units_.search_pair(views_, pairs[k].first, pairs[k].second, scale_, options);
    });
    return done ? std::optional(std::move(found)) : std::nullopt;
  }

  // Errors of a sensor beyond its noise are in all pairs: links that close loops tell them, and
  // from then on they are expected of all. False when asked to stop.
  bool expect_common_errors(const Pairs& pairs, Hypotheses& found) {
    JudgeOptions& judge = grouping_.judge;
    if (judge.min_stddev > 0.0) return true;
    std::vector<PoseLink> links = links_of(pairs, found);
    links.insert(links.end(), known_links_.begin(), known_links_.end());
    judge.min_stddev = stddev_of_loops(surfaces_, links);
    if (judge.min_stddev == 0.0) return true;
    return for_each(links_.size(), "judging poses",
                    [&](std::size_t k) {
                      PoseLink& link = links_[k];
                      link.evidence =
                          judge_pose(surfaces_[link.a], surfaces_[link.b], link.b_from_a, judge);
                    }) &&
           for_each(pairs.size(), "judging poses", [&](std::size_t k) {
             const auto [a, b] = pairs[k];
             for (PoseHypothesis& hypothesis : found[k])
               if (hypothesis.evidence.overlap > 0.0)
                 hypothesis.evidence =
                     judge_pose(surfaces_[a], surfaces_[b], hypothesis.b_from_a, judge);
           });
  }

  std::vector<PoseLink> links_of(const Pairs& pairs, const Hypotheses& found) const {
    std::vector<PoseLink> links;
    for (std::size_t k = 0; k < pairs.size(); ++k)
      for (const PoseHypothesis& hypothesis : found[k])
        if (hypothesis.evidence.overlap >= options_.limits.min_overlap)
          links.push_back(
              {pairs[k].first, pairs[k].second, hypothesis.b_from_a, hypothesis.evidence});
    return links;
  }

  bool search(const Pairs& pairs) {
    auto found = hypotheses_of(pairs);
    if (!found || !expect_common_errors(pairs, *found)) return false;
    std::set<std::size_t> linked_views;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto& [a, b] = pairs[k];
      best_rejected_.add(a, b, (*found)[k]);
      keep_candidates(a, b, (*found)[k]);
      if (!(*found)[k].empty()) linked_views.insert({a, b});
    }
    if (!find_symmetries({linked_views.begin(), linked_views.end()})) return false;
    return link_pairs(pairs, *found);
  }

  void keep_candidates(std::size_t a, std::size_t b, std::vector<PoseHypothesis>& found) {
    if (!pair_links_.keep_candidates(a, b, found, scale_)) return;
    denied_by_plane_[a] = denied_by_plane_[b] = true;
  }

  // False when asked to stop.
  bool find_symmetries(std::vector<std::size_t> views) {
    std::erase_if(views, [&](std::size_t i) { return pair_links_.has_symmetries(i); });
    return for_each(views.size(), "comparing views with themselves", [&](std::size_t k) {
      pair_links_.set_symmetries(views[k], partial_symmetries(views[k]));
    });
  }

  // A view that fits itself at a second place fits other views at a second pose, too.
  std::vector<RigidMotion> partial_symmetries(std::size_t i) const {
    VerificationThresholds alone = pair_links_.widest_limits();
    alone.min_overlap = grouping_.lone_overlap;
    PairSearchOptions search;
    search.judge.association = options_.association;
    search.seeds = 150;
    search.candidates = 20;
    return units_.partial_symmetries(views_[i], i, scale_, alone, search);
  }

  // False when asked to stop.
  bool link_pairs(const Pairs& pairs, const Hypotheses& found) {
    std::vector<std::vector<PoseLink>> links(pairs.size());
    if (!for_each(pairs.size(), "judging poses", [&](std::size_t k) {
          links[k] = pair_links_.of_pair(pairs[k].first, pairs[k].second, found[k], scale_);
        }))
      return false;
    for (const auto& of_pair : links) add_links(of_pair);
    return true;
  }

  void add_links(const std::vector<PoseLink>& links) {
    links_.insert(links_.end(), links.begin(), links.end());
  }

  bool go_on(std::string_view step) const {
    const double fraction =
        ranked_.empty() ? 0.0 : static_cast<double>(next_) / static_cast<double>(ranked_.size());
    return report_progress(progress_, fraction, step);
  }

  const std::vector<ViewSurface> parts_;      // Empty where the views are searched whole.
  const std::vector<ViewSurface>& surfaces_;  // What is searched of the views.
  const ViewGroups& start_;
  const std::vector<bool>& known_;
  const GlobalRegistrationOptions& options_;
  const Progress& progress_;
  const AlignUnits& units_;
  ViewGroupOptions grouping_;
  JudgedPairs judged_;
  PairLinks pair_links_;
  CoarseScale scale_;
  std::vector<CoarseView> views_;
  Pairs ranked_;          // The most promising pairs of views first.
  std::size_t next_ = 0;  // Of them, to be searched.
  std::vector<PoseLink> links_;
  std::vector<PoseLink> known_links_;  // Of these, those of link_known_pairs().
  BestRejectedPoses best_rejected_;
  std::vector<bool> denied_by_plane_;  // See ViewGroups.
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

Result<std::size_t> search_first_pairs(const std::vector<ViewSurface>& surfaces,
                                       const ViewGroups& start, const std::vector<bool>& known,
                                       const GlobalRegistrationOptions& options,
                                       const PairBlock& block, const Progress& progress,
                                       const AlignUnits& units) {
  assert(start.group.size() == surfaces.size() && known.size() == surfaces.size());
  return GlobalRegistration(surfaces, start, known, options, progress, units).search_first(block);
}

}  // namespace relief::registration
