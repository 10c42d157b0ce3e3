#include "registration/calibration/calibration_input.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

// Pairs with the largest overlaps of a view that are used. Bounds time and memory.
constexpr int kMostPairsOfAView = 8;
// One alone shows no error of its sensor, and two agree by a wrong pose as well.
constexpr std::ptrdiff_t kFewestViews = 3;
// Terms of all views: more views have only errors that they share. The terms make dense systems, of
// 8 MB each.
constexpr std::size_t kMostTermsApart = 1000;
// Terms of all sensors: dense systems of 50 MB each.
constexpr std::size_t kMostTerms = 2500;
// More views are left as they are: their pairs are summed several times, and the sums of 200 take
// 200 MB.
constexpr std::ptrdiff_t kMostViews = 200;

std::ptrdiff_t count_linked(std::size_t views, const std::vector<ViewPair>& pairs) {
  const std::vector<bool> linked = linked_views(views, pairs);
  return std::count(linked.begin(), linked.end(), true);
}

}  // namespace

std::vector<ViewPair> fitting_pairs(const Alignment& aligned) {
  std::vector<ViewPair> pairs;
  for (const PairFit& fit : aligned.pairs)
    if (fit.status != PairStatus::kMisfit && aligned.views[fit.a].aligned &&
        aligned.views[fit.b].aligned)
      pairs.push_back({fit.a, fit.b, fit.overlap});
  return largest_overlaps(aligned.views.size(), pairs, kMostPairsOfAView);
}

std::vector<bool> held_views(const std::vector<RangeView>& views,
                             const std::vector<ViewPair>& pairs) {
  const auto group = connected_groups(views.size(), pairs);
  std::vector<bool> held(views.size()), has_held(views.size(), false);
  for (std::size_t i = 0; i < views.size(); ++i) {
    held[i] = views[i].pose == PoseKind::kKnown;
    if (held[i]) has_held[group[i]] = true;
  }
  for (std::size_t i = 0; i < views.size(); ++i)
    if (group[i] == i && !has_held[i]) held[i] = true;
  return held;
}

bool shape_holds_all(const Alignment& aligned) {
  std::vector<bool> paired(aligned.views.size(), false), held(aligned.views.size(), false);
  for (const PairFit& fit : aligned.pairs)
    for (const std::size_t view : {fit.a, fit.b}) {
      paired[view] = true;
      held[view] = held[view] || fit.degenerate_directions.empty();
    }
  return paired == held;
}

std::vector<bool> linked_views(std::size_t views, const std::vector<ViewPair>& pairs) {
  std::vector<bool> linked(views, false);
  for (const ViewPair& pair : pairs) linked[pair.a] = linked[pair.b] = true;
  return linked;
}

bool can_see_sensor_errors(const Alignment& aligned, const std::vector<ViewPair>& pairs,
                           const Sensors& sensors) {
  std::size_t terms = 0;
  for (const SensorModel& sensor : sensors.models) terms += sensor.terms();
  // What poses and terms share is dense as well.
  const bool small =
      terms <= kMostTerms && 6 * aligned.views.size() * terms <= kMostTerms * kMostTerms;
  return count_linked(aligned.views.size(), pairs) >= kFewestViews && small &&
         shape_holds_all(aligned);
}

bool can_be_calibrated(const Alignment& aligned, const std::vector<ViewPair>& pairs,
                       const Sensors& sensors) {
  return count_linked(aligned.views.size(), pairs) <= kMostViews &&
         can_see_sensor_errors(aligned, pairs, sensors);
}

bool may_err_apart(const Sensors& sensors) {
  std::size_t terms = 0;
  for (const std::size_t sensor : sensors.of_view) terms += sensors.models[sensor].terms();
  return terms <= kMostTermsApart;
}

double median_deviation(const std::vector<PairSums>& sums) {
  std::vector<double> deviations;
  for (const PairSums& pair : sums) deviations.push_back(pair.deviation);
  return median_deviation(std::move(deviations));
}

double median_deviation(std::vector<double> deviations) {
  std::erase_if(deviations, [](double deviation) { return deviation <= 0.0; });
  return deviations.empty() ? 0.0 : quantile(std::move(deviations), 0.5);
}

std::vector<const RangeView*> pointers_to(const std::vector<RangeView>& views) {
  std::vector<const RangeView*> pointers;
  for (const RangeView& view : views) pointers.push_back(&view);
  return pointers;
}

RangeView ranges_of(const RangeView& view) {
  RangeView ranges;
  ranges.name = view.name;
  ranges.camera = view.camera;
  ranges.range = view.range;
  ranges.confidence = view.confidence;
  ranges.deviation = view.deviation;
  ranges.samples = view.samples;
  return ranges;
}

}  // namespace relief::registration
