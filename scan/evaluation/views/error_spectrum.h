#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "relief/evaluation/view_errors.h"
#include "relief/scan/grid.h"

namespace relief::evaluation {

/// An error at each pixel: of one component (the imaginary part is then 0) or of two. NaN where
/// there is none.
using ErrorGrid = Grid<std::complex<double>>;

/// Sums of tile spectra, to be accumulated over several grids. Welch's method (1967) in two
/// dimensions: squares of side 16, 32, ... 512 at half-side steps that lie within the data, less
/// their least-squares plane, times a Hann window. At most kMostMissing of a tile may be missing;
/// it is filled in smoothly.
class TileSpectra {
 public:
  /// White noise is right to about twice this (docs/evaluation.md, Spectra of errors).
  static constexpr double kMostMissing = 1.0 / 32.0;

  /// Accumulates the tiles of one grid.
  void add(const ErrorGrid& errors);
  /// Accumulates what another has.
  void add(const TileSpectra& other);

  /// Each band is taken from the smallest tiles that hold eight cycles of it, else from the largest
  /// that cover a quarter of the samples. Nothing below two cycles per tile is given.
  ErrorSpectrum spectrum() const;

 private:
  struct Size {
    int side = 0;
    std::size_t tiles = 0, covered = 0;
    std::vector<double> power;  // by band, summed over tiles and frequencies
  };
  void add_tiles(const ErrorGrid& errors, Size& size);

  std::vector<Size> sizes_;
  std::size_t samples_ = 0;
};

/// The frequency [cycles per sample] above which `noisy_high` has more power than `noisy_low` and
/// below which it has less, interpolated between bands; nothing when they do not cross like that at
/// frequencies up to a quarter, beyond which central differences fade.
std::optional<double> crossing_frequency(const ErrorSpectrum& noisy_high,
                                         const ErrorSpectrum& noisy_low);

}  // namespace relief::evaluation
