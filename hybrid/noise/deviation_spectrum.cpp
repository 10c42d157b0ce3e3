#include "hybrid/noise/deviation_spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "scan/base/median.h"

namespace relief::hybrid {

namespace {

constexpr std::array<int, 7> kWalks{1, 2, 4, 8, 16, 32, 64};  // [edges]; an octave each.

// Values a band is told by at least, and at most: to 5 % (1.17 / sqrt(n)), in a few milliseconds.
constexpr std::size_t kFewestOfBand = 500, kMostOfBand = 40'000;

// The discrepancies along one row or column, summed from its start; a walk without a gap has as
// many edges as it is long.
struct DiscrepancyLine {
  std::vector<double> sum{0.0};
  std::vector<int> edges{0};

  void add(float discrepancy) {
    const bool there = !std::isnan(discrepancy);
    sum.push_back(sum.back() + (there ? discrepancy : 0.0f));
    edges.push_back(edges.back() + (there ? 1 : 0));
  }
  int length() const { return static_cast<int>(sum.size()) - 1; }
};

// |second differences| of the ranges less the implied ones, measured and moved.
struct BandDifferences {
  std::vector<float> measured, refined;

  // `moved(i)`: what the sample at the start of edge i moved by.
  template <typename Moved>
  void add(const DiscrepancyLine& line, int k, int step, const Moved& moved) {
    for (int i = 0; i + 2 * k <= line.length(); i += step) {
      const auto at = [&](int n) { return static_cast<std::size_t>(i + n * k); };
      if (line.edges[at(2)] - line.edges[at(0)] != 2 * k) continue;
      const double measured = line.sum[at(2)] - 2.0 * line.sum[at(1)] + line.sum[at(0)];
      const double change = moved(i + 2 * k) - 2.0 * moved(i + k) + moved(i);
      this->measured.push_back(static_cast<float>(std::abs(measured)));
      refined.push_back(static_cast<float>(std::abs(measured + change)));
    }
  }
};

// Of independent errors of one sample; the square of a second difference has six times their
// variance.
double of_one_sample(std::vector<float>& differences) {
  return kSigmaPerMedian * static_cast<double>(median(differences)) / std::sqrt(6.0);
}

BandDifferences differences_over(const RangeSteps& steps, const Grid<float>& moved, int k) {
  const auto& rows = steps.along_rows.discrepancy;
  const auto& columns = steps.along_columns.discrepancy;
  // Walks start so far apart that no more than kMostOfBand are looked at.
  const std::size_t walks = 2 * rows.size() / static_cast<std::size_t>(std::max(1, k / 2));
  const int step = std::max(1, k / 2);
  const auto thin = static_cast<int>(std::max<std::size_t>(1, walks / kMostOfBand));
  BandDifferences differences;
  for (int v = 0; v < rows.height(); v += thin) {
    DiscrepancyLine line;
    for (int u = 0; u + 1 < rows.width(); ++u) line.add(rows(u, v));
    differences.add(line, k, step, [&](int u) { return static_cast<double>(moved(u, v)); });
  }
  for (int u = 0; u < columns.width(); u += thin) {
    DiscrepancyLine line;
    for (int v = 0; v + 1 < columns.height(); ++v) line.add(columns(u, v));
    differences.add(line, k, step, [&](int v) { return static_cast<double>(moved(u, v)); });
  }
  return differences;
}

}  // namespace

std::vector<DeviationBand> deviation_spectrum(const RangeSteps& steps, const Grid<float>& moved) {
  std::vector<DeviationBand> bands;
  for (const int k : kWalks) {
    BandDifferences found = differences_over(steps, moved, k);
    if (found.measured.size() < kFewestOfBand) break;
    // Second differences over walks of k edges see waves of 2 k samples most.
    bands.push_back({2.0 * k, of_one_sample(found.measured), of_one_sample(found.refined)});
  }
  return bands;
}

}  // namespace relief::hybrid
