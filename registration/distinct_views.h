#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// Views without those that are copies of others (originals_of()). A copy fits its original
/// whatever errors both have, and repeats what that says of other views: judged by it, or among the
/// pairs whose deviations give limits, it counts as evidence that nobody measured. So views are
/// aligned and calibrated without copies. These get what is found for their originals.
class DistinctViews {
 public:
  /// The views outlive this. They are copied only where there are copies among them.
  explicit DistinctViews(const std::vector<RangeView>& views);

  const std::vector<RangeView>& views() const { return distinct_ ? *distinct_ : all_; }

  /// Where in views() a view is, or the original that it is a copy of.
  std::size_t place_of(std::size_t view) const { return place_[view]; }

  /// views() with the guesses of copies in place of those of originals that `aligned` does not
  /// verify. Nothing where no guesses differ.
  std::optional<std::vector<RangeView>> with_guesses_of_copies(const Alignment& aligned) const;

  /// What was found for views(), and the other way round. Pairs of a view are also those of its
  /// copies, which have no pair with each other. A known pose of a copy stays: where the original
  /// is elsewhere, the copy is unverified.
  Alignment with_copies(Alignment aligned) const;
  SensorCalibration with_copies(SensorCalibration calibration) const;
  Alignment without_copies(const Alignment& aligned) const;

 private:
  std::vector<std::vector<std::size_t>> members() const;
  ViewReport report_of_copy(std::size_t i, const ViewReport& original) const;

  const std::vector<RangeView>& all_;
  std::optional<std::vector<RangeView>> distinct_;  // Where some are copies.
  std::vector<std::size_t> originals_;              // Of all_, in it.
  std::vector<std::size_t> place_;                  // Of the originals of all_, in views().
};

}  // namespace relief::registration
