#include "fusion/views/contradicted_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include "fusion/views/view_difference.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Samples that are looked at, of all views, and of each: fractions of 0.1 are then certain to 0.02
// at worst.
constexpr std::size_t kAllSamples = 20'000, kLeastOfView = 300, kMostOfView = 1000;

// Judged samples of a view, at least: one of ten is certain to 0.03 then.
constexpr std::size_t kFewestJudged = 100;

// Views that outvote a sample, at least: of two that differ either may be wrong.
constexpr std::size_t kFewestAgainst = 2;

// At right poses fewer samples stand in space seen empty, as registration has it: stray samples,
// flying pixels, moving parts.
constexpr double kStrayPart = 0.1;

// More than so many times what is usual is not usual.
constexpr double kUnusual = 2.0;

// Copies of a view have its samples to the bit, wherever they are: the number of the first view
// with the same ones.
std::vector<std::size_t> originals_of(const std::vector<ViewSampler>& views) {
  std::vector<std::size_t> original(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    for (original[i] = 0; views[original[i]].spacing() != views[i].spacing() ||
                          views[original[i]].noise() != views[i].noise();)
      ++original[i];
  return original;
}

class Judge {
 public:
  Judge(const std::vector<ViewSampler>& views, const RangeErrors& errors)
      : views_(views),
        stddev_(errors.stddev),
        original_(originals_of(views)),
        samples_(std::clamp(kAllSamples / std::max<std::size_t>(1, views.size()), kLeastOfView,
                            kMostOfView)) {}

  // The part of the samples that is outvoted; nothing where too few are judged.
  std::optional<double> outvoted(std::size_t view) const {
    const std::vector<ObservedSample> samples = some_samples(views_[view], samples_);
    const std::vector<std::size_t> others = witnesses(view, samples);
    std::size_t judged = 0, against = 0;
    for (const ObservedSample& sample : samples) {
      check_stop_and_memory();  // All witnesses are looked at.
      const Verdict verdict = verdict_on(view, sample, others);
      judged += verdict == Verdict::kNone ? 0 : 1;
      against += verdict == Verdict::kOutvoted ? 1 : 0;
    }
    if (judged < kFewestJudged) return std::nullopt;
    return static_cast<double>(against) / static_cast<double>(judged);
  }

 private:
  enum class Verdict { kNone, kConfirmed, kOutvoted };

  // The other views that may say something of the samples, without copies of the view.
  std::vector<std::size_t> witnesses(std::size_t view,
                                     const std::vector<ObservedSample>& samples) const {
    Eigen::AlignedBox3d box;
    for (const ObservedSample& sample : samples) box.extend(sample.position);
    std::vector<std::size_t> others;
    for (std::size_t other = 0; other < views_.size(); ++other)
      if (original_[other] != original_[view] &&
          views_[other].concerns(box, reach_of_difference(views_[other])))
        others.push_back(other);
    return others;
  }

  Verdict verdict_on(std::size_t view, const ObservedSample& sample,
                     const std::vector<std::size_t>& others) const {
    const auto& [position, own] = sample;
    std::map<std::size_t, double> distances;  // In units of what is far, by original.
    for (const std::size_t other : others) {
      const auto found = difference_from(views_[other], position, own.normal, kInside);
      if (!found) continue;
      const double distance =
          found->distance / far(view, other, std::max(own.relative_stddev, found->relative_stddev));
      const auto [known, first] = distances.try_emplace(original_[other], distance);
      if (!first && std::abs(distance) < std::abs(known->second)) known->second = distance;
    }
    std::size_t in_front = 0, behind = 0, agree = 0;
    for (const auto& [original, distance] : distances)
      ++(distance > 1.0 ? in_front : distance < -1.0 ? behind : agree);
    const std::size_t against = std::max(in_front, behind);
    if (against >= kFewestAgainst && against >= 2 * (1 + agree)) return Verdict::kOutvoted;
    return agree > 0 ? Verdict::kConfirmed : Verdict::kNone;
  }

  double far(std::size_t a, std::size_t b, double relative_stddev) const {
    const double of_two = std::sqrt(2.0) * stddev_ * std::max(1.0, relative_stddev);
    const double noise = std::hypot(views_[a].noise(), views_[b].noise());
    return std::max(
        {kTruncatedDeviations * std::max(of_two, noise), views_[a].spacing(), views_[b].spacing()});
  }

  const std::vector<ViewSampler>& views_;
  double stddev_;
  std::vector<std::size_t> original_;
  std::size_t samples_;
};

}  // namespace

std::vector<ViewContradiction> judge_views(const std::vector<ViewSampler>& views,
                                           const RangeErrors& errors) {
  std::vector<ViewContradiction> result(views.size());
  if (views.size() <= kFewestAgainst || !(errors.stddev > 0.0)) return result;
  const Judge judge(views, errors);
  const auto outvoted = parallel_map<std::optional<double>>(
      views.size(), [&](std::size_t i) { return judge.outvoted(i); });
  std::vector<double> known;
  for (const auto& part : outvoted)
    if (part) known.push_back(*part);
  const double usual = median(std::move(known));
  for (std::size_t i = 0; i < views.size(); ++i) {
    result[i].outvoted = outvoted[i].value_or(0.0);
    result[i].contradicted = result[i].outvoted > std::max(kStrayPart, kUnusual * usual);
  }
  return result;
}

}  // namespace relief::fusion
