#pragma once

#include <cstddef>
#include <vector>

namespace relief::evaluation {

/// Summary of the magnitudes of some errors. All zero when there are none.
struct ErrorStatistics {
  std::size_t count = 0;
  double mean = 0.0;
  double median = 0.0;
  double rms = 0.0;
  double p95 = 0.0;  ///< 95 of 100 are at most this.
  double max = 0.0;
};

/// Statistics of |errors|, which must be finite. Quantiles are order statistics, not interpolated.
ErrorStatistics summarize(std::vector<double> errors);

}  // namespace relief::evaluation
