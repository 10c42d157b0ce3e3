#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "scan/base/median.h"

namespace relief::registration {

/// A pair of views that deviates by so many times the median of all pairs is uncommon. Chance alone
/// scatters an RMS of 50 residuals by 10 % (1 / sqrt(2 n)); incidence and range do the rest.
inline constexpr double kUncommon = 2.0;

/// The value at `fraction` in [0, 1] of the sorted values; 0 for none. Reorders its copy only.
inline double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  const auto last = static_cast<double>(values.size() - 1);
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(fraction * last);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Robust standard deviation about zero: insensitive to almost half of the values being outliers.
inline double robust_sigma(std::vector<double> residuals) {
  for (double& residual : residuals) residual = std::abs(residual);
  return kSigmaPerMedian * quantile(std::move(residuals), 0.5);
}

/// The weight that iterative reweighting gives a whitened residual under the Cauchy loss of scale
/// `c`, rho(r) = c^2 log(1 + (r/c)^2).
inline double cauchy_weight(double residual, double c) {
  const double ratio = residual / c;
  return 1.0 / (1.0 + ratio * ratio);
}

/// The sum of Cauchy losses c^2 log(1 + s / c^2) over squared residuals s.
class CauchyLosses {
 public:
  explicit CauchyLosses(double scale) : square_(scale * scale) {}

  /// Adds the loss of a squared residual and gives the weight that goes with it.
  double add(double squared) {
    const double factor = 1.0 + squared / square_;
    product_ *= factor;
    if (product_ > kLargest) {
      logs_ += std::log(product_);
      product_ = 1.0;
    }
    return 1.0 / factor;
  }

  double sum() const { return square_ * (logs_ + std::log(product_)); }

 private:
  static constexpr double kLargest = 1e100;  // Times a factor below 1e208 it is a double.
  double square_, logs_ = 0.0, product_ = 1.0;
};

}  // namespace relief::registration
