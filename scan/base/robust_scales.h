#pragma once

namespace relief {

// Scales of robust losses at which 95 % of the efficiency of least squares is kept on Gaussian
// residuals (Holland and Welsch 1977) [standard deviations].

/// Where the Cauchy loss turns from quadratic to logarithmic.
inline constexpr double kCauchyScale = 2.385;

/// Where Tukey's biweight ends: residuals beyond do not count.
inline constexpr double kTukeyScale = 4.685;

}  // namespace relief
