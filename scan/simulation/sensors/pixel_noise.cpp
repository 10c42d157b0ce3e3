#include "scan/simulation/sensors/pixel_noise.h"

#include <cmath>
#include <vector>

#include "scan/base/counter_random.h"
#include "scan/base/parallel.h"

namespace relief::simulation {

namespace {

// A Gaussian kernel from its middle outwards, its squares summing to 1: white noise keeps its
// variance. Smoothing twice by it, once per axis, gives the correlation exp(-r^2 / (4 sigma^2)).
std::vector<double> kernel_half(double correlation) {
  const double sigma = 0.5 * correlation;
  std::vector<double> half;
  double squares = 0.0;
  for (int k = 0; k <= static_cast<int>(std::ceil(3.5 * sigma)); ++k) {
    half.push_back(std::exp(-0.5 * (k / sigma) * (k / sigma)));
    squares += (k == 0 ? 1.0 : 2.0) * half.back() * half.back();
  }
  for (double& weight : half) weight /= std::sqrt(squares);
  return half;
}

Grid<double> white_noise(int width, int height, const RandomStream& stream) {
  const CounterRandom random(stream.seed, stream.stream);
  Grid<double> noise(width, height);
  parallel_for(noise.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) noise[i] = random.normal(i);
  });
  return noise;
}

// Correlates the rows with the kernel and transposes: the margin of the kernel is lost.
Grid<double> smoothed_rows(const Grid<double>& noise, const std::vector<double>& half) {
  const int margin = static_cast<int>(half.size()) - 1, width = noise.width() - 2 * margin;
  Grid<double> smooth(noise.height(), width);
  parallel_for(static_cast<std::size_t>(noise.height()), 16,
               [&](std::size_t begin, std::size_t end) {
                 for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                   for (int u = 0; u < width; ++u) {
                     double sum = half[0] * noise(u + margin, v);
                     for (int k = 1; k <= margin; ++k)
                       sum += half[static_cast<std::size_t>(k)] *
                              (noise(u + margin - k, v) + noise(u + margin + k, v));
                     smooth(v, u) = sum;
                   }
                 }
               });
  return smooth;
}

}  // namespace

Grid<double> pixel_noise(int width, int height, double correlation, const RandomStream& random) {
  if (correlation < 0.5) return white_noise(width, height, random);
  const std::vector<double> half = kernel_half(correlation);
  const int margin = static_cast<int>(half.size()) - 1;
  const Grid<double> white = white_noise(width + 2 * margin, height + 2 * margin, random);
  return smoothed_rows(smoothed_rows(white, half), half);
}

}  // namespace relief::simulation
