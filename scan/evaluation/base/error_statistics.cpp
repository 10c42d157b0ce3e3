#include "relief/evaluation/error_statistics.h"

#include <algorithm>
#include <cmath>

namespace relief::evaluation {

namespace {

double order_statistic(std::vector<double>& values, double fraction) {
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(fraction * static_cast<double>(values.size())) - 1.0);
  const auto place = values.begin() + std::max<std::ptrdiff_t>(rank, 0);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

ErrorStatistics summarize(std::vector<double> errors) {
  ErrorStatistics statistics;
  statistics.count = errors.size();
  if (errors.empty()) return statistics;
  double sum = 0.0, squares = 0.0;
  for (double& error : errors) {
    error = std::abs(error);
    sum += error;
    squares += error * error;
    statistics.max = std::max(statistics.max, error);
  }
  const double count = static_cast<double>(errors.size());
  statistics.mean = sum / count;
  statistics.rms = std::sqrt(squares / count);
  statistics.median = order_statistic(errors, 0.5);
  statistics.p95 = order_statistic(errors, 0.95);
  return statistics;
}

}  // namespace relief::evaluation
