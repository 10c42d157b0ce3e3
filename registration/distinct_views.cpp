#include "registration/distinct_views.h"

#include <algorithm>
#include <utility>

#include "scan/views/view_copies.h"

namespace relief::registration {

DistinctViews::DistinctViews(const std::vector<RangeView>& views)
    : all_(views), originals_(originals_of(views)), place_(views.size()) {
  std::vector<std::size_t> distinct;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (originals_[i] != i) continue;
    place_[i] = distinct.size();
    distinct.push_back(i);
  }
  for (std::size_t i = 0; i < views.size(); ++i) place_[i] = place_[originals_[i]];
  if (distinct.size() == views.size()) return;
  distinct_.emplace();
  for (const std::size_t i : distinct) distinct_->push_back(views[i]);
}

std::optional<std::vector<RangeView>> DistinctViews::with_guesses_of_copies(
    const Alignment& aligned) const {
  std::optional<std::vector<RangeView>> others;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const RangeView& original = all_[originals_[i]];
    if (originals_[i] == i || original.pose != PoseKind::kGuess ||
        all_[i].pose != PoseKind::kGuess ||
        aligned.views[place_[i]].status == PoseStatus::kVerified ||
        all_[i].world_from_view.matrix() == original.world_from_view.matrix())
      continue;
    if (!others) others = views();
    (*others)[place_[i]].world_from_view = all_[i].world_from_view;
  }
  return others;
}

// Of each of views() the index in all_, and those of its copies.
std::vector<std::vector<std::size_t>> DistinctViews::members() const {
  std::vector<std::vector<std::size_t>> members(views().size());
  for (std::size_t i = 0; i < all_.size(); ++i) members[place_[i]].push_back(i);
  return members;
}

ViewReport DistinctViews::report_of_copy(std::size_t i, const ViewReport& original) const {
  ViewReport report = original;
  report.name = all_[i].name;
  if (all_[i].pose != PoseKind::kKnown ||
      all_[i].world_from_view.matrix() == original.world_from_view.matrix())
    return report;
  report.world_from_view = all_[i].world_from_view;
  report.pose_covariance.setZero();
  report.sensor_covariance.setZero();
  report.pose_std.setZero();
  report.kept_motions.clear();
  report.aligned = true;
  report.status = PoseStatus::kUnverified;
  report.reason = "its ranges are those of " + original.name + ", which is at another pose";
  return report;
}

Alignment DistinctViews::with_copies(Alignment aligned) const {
  if (!distinct_) return aligned;
  const auto members = this->members();
  Alignment result = std::move(aligned);
  const std::vector<ViewReport> found = std::exchange(result.views, {});
  for (std::size_t i = 0; i < all_.size(); ++i)
    result.views.push_back(originals_[i] == i ? found[place_[i]]
                                              : report_of_copy(i, found[place_[i]]));
  for (const PairFit& pair : std::exchange(result.pairs, {}))
    for (const std::size_t a : members[pair.a])
      for (const std::size_t b : members[pair.b]) {
        result.pairs.push_back(pair);
        result.pairs.back().a = std::min(a, b);
        result.pairs.back().b = std::max(a, b);
      }
  std::ranges::sort(result.pairs, {},
                    [](const PairFit& pair) { return std::pair(pair.a, pair.b); });
  for (LoopClosure& loop : result.loops)
    for (std::size_t& view : loop.views) view = originals_[members[view].front()];
  return result;
}

SensorCalibration DistinctViews::with_copies(SensorCalibration calibration) const {
  if (!distinct_ || !calibration.found()) return calibration;
  const std::vector<ViewCalibration> found = std::exchange(calibration.views, {});
  for (const std::size_t place : place_) calibration.views.push_back(found[place]);
  calibration.alignment = with_copies(std::move(calibration.alignment));
  return calibration;
}

Alignment DistinctViews::without_copies(const Alignment& aligned) const {
  if (!distinct_) return aligned;
  Alignment result = aligned;
  result.views.clear();
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (originals_[i] == i) result.views.push_back(aligned.views[i]);
  std::erase_if(result.pairs, [&](const PairFit& pair) {
    return originals_[pair.a] != pair.a || originals_[pair.b] != pair.b;
  });
  for (PairFit& pair : result.pairs) {
    pair.a = place_[pair.a];
    pair.b = place_[pair.b];
  }
  for (LoopClosure& loop : result.loops)
    for (std::size_t& view : loop.views) view = place_[view];
  return result;
}

}  // namespace relief::registration
