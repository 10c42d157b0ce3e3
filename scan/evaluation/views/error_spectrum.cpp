#include "scan/evaluation/views/error_spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <unsupported/Eigen/FFT>

namespace relief::evaluation {

namespace {

using Tile = Eigen::MatrixXcd;

constexpr int kSmallestTile = 16, kLargestTile = 512;  // [samples]
constexpr int kBandsPerOctave = 4;
constexpr int kBands = 40;  // Ten octaves, to 2^(-10.5): below 1 / kLargestTile = 2^(-9).
// The cycles that a band should have in a tile, and must have. From 8 on a band is as wide as the
// window's main lobe at half power: 8 (2^(1/4) - 1) = 1.51 against 1.44; that lobe ends at 2.
constexpr double kGoodCycles = 8.0, kFewestCycles = 2.0;
// Fraction of the samples that tiles must cover. Less stands for small parts of the views only;
// more leaves out the lowest bands of views with gaps.
constexpr double kLeastCoverage = 0.25;

// Band 0 ends at sqrt(1/2), the corner of the square of frequencies.
double band_high(int band) { return std::exp2(-0.5 - static_cast<double>(band) / kBandsPerOctave); }

int band_of(double frequency) {
  const double place = -kBandsPerOctave * (std::log2(frequency) + 0.5);
  return std::max(0, static_cast<int>(std::floor(place + 1e-9)));
}

// The signed frequency of entry k of a transform of length n [cycles per sample].
double entry_frequency(int k, int n) { return static_cast<double>(k <= n / 2 ? k : k - n) / n; }

bool missing(const std::complex<double>& value) { return std::isnan(value.real()); }

// What the entries of a transform of this size are, band by band.
struct BandLayout {
  std::vector<int> band;  // of each entry, column by column; -1: the mean
  std::vector<double> entries = std::vector<double>(kBands, 0.0);
  std::vector<double> frequency_sum = std::vector<double>(kBands, 0.0);

  explicit BandLayout(int side) {
    for (int column = 0; column < side; ++column) {
      for (int row = 0; row < side; ++row) {
        const double frequency =
            std::hypot(entry_frequency(column, side), entry_frequency(row, side));
        band.push_back(frequency > 0.0 ? band_of(frequency) : -1);
        if (frequency == 0.0) continue;
        ++entries[band.back()];
        frequency_sum[band.back()] += frequency;
      }
    }
  }
};

// The tile with this corner, if enough of it is there.
bool cut_tile(const ErrorGrid& errors, int u0, int v0, Tile& tile) {
  Eigen::Index absent = 0;
  for (int v = 0; v < tile.cols(); ++v) {
    for (int u = 0; u < tile.rows(); ++u) {
      tile(u, v) = errors(u0 + u, v0 + v);
      absent += missing(tile(u, v));
    }
  }
  return static_cast<double>(absent) <=
         TileSpectra::kMostMissing * static_cast<double>(tile.size());
}

// Subtracts the least-squares plane of the entries that are there.
void remove_plane(Tile& tile) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3cd right = Eigen::Vector3cd::Zero();
  const double middle = 0.5 * static_cast<double>(tile.rows() - 1);
  const auto basis = [&](Eigen::Index u, Eigen::Index v) {
    return Eigen::Vector3d(1.0, static_cast<double>(u) - middle, static_cast<double>(v) - middle);
  };
  for (Eigen::Index v = 0; v < tile.cols(); ++v) {
    for (Eigen::Index u = 0; u < tile.rows(); ++u) {
      if (missing(tile(u, v))) continue;
      normal += basis(u, v) * basis(u, v).transpose();
      right += basis(u, v) * tile(u, v);
    }
  }
  const Eigen::Vector3cd plane = normal.ldlt().solve(right);
  for (Eigen::Index v = 0; v < tile.cols(); ++v)
    for (Eigen::Index u = 0; u < tile.rows(); ++u)
      tile(u, v) -= (basis(u, v).cast<std::complex<double>>().transpose() * plane).value();
}

// Replaces what is missing by a membrane through what is beside it: each the mean of its four
// neighbours. Holes are small, so that a fixed number of relaxations suffices.
void fill_missing(Tile& tile) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> absent;
  for (Eigen::Index v = 0; v < tile.cols(); ++v)
    for (Eigen::Index u = 0; u < tile.rows(); ++u)
      if (missing(tile(u, v))) absent.emplace_back(u, v);
  for (const auto& [u, v] : absent) tile(u, v) = 0.0;
  // Of a hole of n x n the error falls by cos^2(pi / (n + 1)) a round (Gauss-Seidel): in 30 rounds
  // to 2e-4 for n = 5, and to 2 % for n = 8.
  constexpr int kRelaxations = 30;
  for (int round = 0; round < kRelaxations && !absent.empty(); ++round) {
    for (const auto& [u, v] : absent) {
      std::complex<double> sum = 0.0;
      double count = 0.0;
      const auto take = [&](Eigen::Index i, Eigen::Index j) {
        if (i < 0 || j < 0 || i >= tile.rows() || j >= tile.cols()) return;
        sum += tile(i, j);
        count += 1.0;
      };
      take(u - 1, v), take(u + 1, v), take(u, v - 1), take(u, v + 1);
      tile(u, v) = sum / count;
    }
  }
}

Eigen::VectorXd hann_window(int side) {
  Eigen::VectorXd window(side);
  for (int i = 0; i < side; ++i)
    window[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (i + 0.5) / side);
  return window;
}

// The transform along columns, then along rows, in place.
void transform(Eigen::FFT<double>& fft, Tile& tile) {
  Eigen::VectorXcd line(tile.rows()), result(tile.rows());
  for (int pass = 0; pass < 2; ++pass) {
    for (Eigen::Index i = 0; i < tile.cols(); ++i) {
      line = tile.col(i);
      fft.fwd(result, line);
      tile.col(i) = result;
    }
    tile.transposeInPlace();
  }
}

}  // namespace

double ErrorSpectrum::variance() const {
  double sum = 0.0;
  for (const SpectrumBand& band : bands) sum += band.density * band.area;
  return sum;
}

// Equation (E6).
void TileSpectra::add_tiles(const ErrorGrid& errors, Size& size) {
  const int side = size.side, step = side / 2;
  const BandLayout layout(side);
  const Eigen::VectorXd window = hann_window(side);
  Grid<std::uint8_t> covered(errors.width(), errors.height(), 0);
  Eigen::FFT<double> fft;
  Tile tile(side, side);
  for (int v0 = 0; v0 + side <= errors.height(); v0 += step) {
    for (int u0 = 0; u0 + side <= errors.width(); u0 += step) {
      if (!cut_tile(errors, u0, v0, tile)) continue;
      for (int v = v0; v < v0 + side; ++v)
        for (int u = u0; u < u0 + side; ++u) covered(u, v) = !missing(errors(u, v));
      remove_plane(tile);
      fill_missing(tile);
      tile = (window.asDiagonal() * tile * window.asDiagonal()).eval();
      transform(fft, tile);
      const double scale = 1.0 / (window.squaredNorm() * window.squaredNorm());
      for (Eigen::Index i = 0; i < tile.size(); ++i)
        if (layout.band[i] >= 0) size.power[layout.band[i]] += scale * std::norm(tile(i));
      ++size.tiles;
    }
  }
  for (const std::uint8_t here : covered) size.covered += here;
}

void TileSpectra::add(const ErrorGrid& errors) {
  for (const auto& error : errors) samples_ += !missing(error);
  std::size_t index = 0;
  for (int side = kSmallestTile; side <= kLargestTile; side *= 2, ++index) {
    if (side > std::min(errors.width(), errors.height())) break;
    if (index == sizes_.size()) sizes_.push_back({side, 0, 0, std::vector<double>(kBands, 0.0)});
    add_tiles(errors, sizes_[index]);
  }
}

void TileSpectra::add(const TileSpectra& other) {
  samples_ += other.samples_;
  for (std::size_t i = 0; i < other.sizes_.size(); ++i) {
    const Size& added = other.sizes_[i];
    if (i == sizes_.size()) {
      sizes_.push_back(added);
      continue;
    }
    sizes_[i].tiles += added.tiles;
    sizes_[i].covered += added.covered;
    for (int band = 0; band < kBands; ++band) sizes_[i].power[band] += added.power[band];
  }
}

ErrorSpectrum TileSpectra::spectrum() const {
  ErrorSpectrum spectrum;
  const auto coverage = [&](const Size& size) {
    return static_cast<double>(size.covered) / static_cast<double>(samples_);
  };
  std::vector<const Size*> usable;
  for (const Size& size : sizes_)
    if (size.tiles > 0 && (usable.empty() || coverage(size) >= kLeastCoverage))
      usable.push_back(&size);
  if (usable.empty()) return spectrum;
  spectrum.finest_coverage = coverage(*usable.front());
  spectrum.coarsest_coverage = coverage(*usable.back());

  std::vector<BandLayout> layouts;
  for (const Size* size : usable) layouts.emplace_back(size->side);
  for (int band = kBands - 1; band >= 0; --band) {
    const double low = band_high(band + 1);
    std::size_t chosen = 0;
    while (chosen + 1 < usable.size() && low * usable[chosen]->side < kGoodCycles) ++chosen;
    const Size& size = *usable[chosen];
    const double entries = layouts[chosen].entries[band];
    if (low * size.side < kFewestCycles - 1e-9 || entries == 0.0) continue;
    const double tiles = static_cast<double>(size.tiles);
    spectrum.bands.push_back({low, band_high(band), layouts[chosen].frequency_sum[band] / entries,
                              size.power[band] / (entries * tiles),
                              entries / (static_cast<double>(size.side) * size.side), size.side,
                              size.tiles});
  }
  return spectrum;
}

std::optional<double> crossing_frequency(const ErrorSpectrum& noisy_high,
                                         const ErrorSpectrum& noisy_low) {
  // [cycles per sample] Beyond it central differences fade: they show sin(2 pi f) / (2 pi f).
  constexpr double kHighest = 0.25;
  std::optional<double> previous_frequency, previous_ratio;
  for (const SpectrumBand& high : noisy_high.bands) {
    const auto low = std::find_if(noisy_low.bands.begin(), noisy_low.bands.end(),
                                  [&](const auto& band) { return band.low == high.low; });
    if (low == noisy_low.bands.end() || high.frequency > kHighest) continue;
    if (!(high.density > 0.0 && low->density > 0.0)) continue;
    const double frequency = std::log(high.frequency);
    const double ratio = std::log(high.density / low->density);
    if (previous_ratio && *previous_ratio < 0.0 && ratio >= 0.0) {
      const double share = *previous_ratio / (*previous_ratio - ratio);
      return std::exp(*previous_frequency + share * (frequency - *previous_frequency));
    }
    previous_frequency = frequency;
    previous_ratio = ratio;
  }
  return std::nullopt;
}

}  // namespace relief::evaluation
