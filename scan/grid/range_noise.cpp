#include "scan/grid/range_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "scan/base/gaussian_core.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

// The view is cut into tiles of one noise each: some thirty along the longer side, but none so
// small that its noise is not known to about a tenth: 16 x 16 and 24 x 24 differences tell it to
// 0.13 and 0.09 (see kLogVariance), 30 to 0.4. Fewer tiles blur where the noise changes; more
// matter beyond 512 samples along a side only.
constexpr int kTilesAlong = 32;
constexpr int kLeastTile = 16;  // [samples]
// At most so many differences along the side of a tile are used, which bounds the time: 9 x 9 that
// have no sample in common tell the noise to 0.13 as well.
constexpr int kAlongTile = 24;
constexpr int kFewestInTile = 32;  // Overlapping ones, or as many as tell as much.
constexpr std::size_t kFewest = 30;

// Variance of the logarithm of core_sigma(), times the number of differences it is from: 1.28 for
// independent Gaussian ones, and at most 1.28 (70/36)^2 = 4.8 for overlapping squares. Half of it
// takes chance for changes of the noise; twice as much misses small ones. Thinned out, squares have
// no sample in common and lines their ends.
constexpr double kLogVariance = 4.5, kThinnedLogVariance = 1.28;

// The map is given where tiles differ by more than chance by at least this, one standard deviation
// of the logarithm. To weigh alike what differs so costs 4 % of a mean's variance: exp(4 0.1^2).
constexpr double kLeastSpread = 0.1;

// Squares that show less than this part of what lines do are blind [ratio of standard deviations].
// White noise gives 1; noise with the correlation exp(-(r/l)^2) 0.41, 0.27, 0.20 at l = 2, 3, 4.
constexpr double kSeesNothing = 0.2;

// Differences up to this part of the distance are rounding of single precision, in which most files
// hold coordinates: eight halves of a last place. Rounded ranges that were put on other rays have
// such in place of zeros.
constexpr double kRounding = 8.0 * 0x1p-24;

// A difference of samples that a smooth surface does not show, scaled to the standard deviation of
// one of them. Of 3 x 3 samples, (1, -2, 1) along both directions: blind to all relief that does
// not change along both. Of four samples in a line where too few squares are whole.
enum class Stencil { kSquare, kAlongRows, kAlongColumns };

double square_difference(const RangeView& view, int u, int v) {
  constexpr std::array<double, 3> kSecond{1.0, -2.0, 1.0};  // The second difference.
  double sum = 0.0;
  for (int dv = 0; dv < 3; ++dv)
    for (int du = 0; du < 3; ++du)
      sum += kSecond[static_cast<std::size_t>(du)] * kSecond[static_cast<std::size_t>(dv)] *
             view.range(u + du, v + dv);
  return sum / 6.0;
}

double line_difference(const RangeView& view, int u, int v, int du, int dv) {
  const auto t = [&](int k) { return view.range(u + k * du, v + k * dv); };
  return (t(0) - 3.0 * t(1) + 3.0 * t(2) - t(3)) / std::sqrt(20.0);
}

// Standard deviation of the Gaussian core of absolute values: the fixed point of the second moment
// of what lies within two standard deviations. Starts low, to withstand many outliers, but above
// the zeros of rounded ranges.
double core_sigma(std::vector<float>& values) {
  double sigma = starting_sigma(values);
  for (int round = 0; round < 30 && sigma > 0.0; ++round) {
    double squares = 0.0, count = 0.0;
    for (const float value : values) {
      if (!(value < kCoreCut * sigma)) continue;
      squares += double{value} * value;
      count += 1.0;
    }
    if (!(squares > 0.0)) break;
    const double before = std::exchange(sigma, std::sqrt(squares / count / kCoreMoment));
    if (std::abs(sigma - before) <= 1e-3 * sigma) break;
  }
  return sigma;
}

struct Tile {
  std::vector<float> differences;  // Absolute [unit].
  double log_sigma = 0.0, variance = 0.0;
  bool known() const { return variance > 0.0; }
};

class TiledNoise {
 public:
  /// `keep_rounding`: differences that are rounding stay as they are, in place of zeros.
  TiledNoise(const RangeView& view, const RangeQuantisation& quantisation,
             bool keep_rounding = false)
      : view_(view), quantisation_(quantisation), keep_rounding_(keep_rounding) {
    const int longer = std::max(view.width(), view.height());
    side_ = std::max(kLeastTile, (longer + kTilesAlong - 1) / kTilesAlong);
    // Odd, so that all rows and columns show where every second or fourth is interpolated.
    stride_ = (side_ + kAlongTile - 1) / kAlongTile | 1;
    tiles_ = Grid<Tile>((view.width() + side_ - 1) / side_, (view.height() + side_ - 1) / side_);
  }

  RangeNoise estimate() {
    RangeNoise noise;
    noise.quantisation = quantisation_;
    collect(Stencil::kSquare);
    noise.sigma = sigma_of_all();
    // Squares are three times as hard to have as lines where samples are missing at random.
    const bool few = 8 * count() < places(), blind = !few && squares_see_nothing();
    if (few || blind) {
      collect(louder_lines());
      noise.sigma = sigma_of_all();
    }
    noise.differences = count();
    if (noise.differences < kFewest) return {quantisation_, 0.0, {}, 0.0, noise.differences};
    find_tile_sigmas();
    // Interpolated samples show in each tile another part of the noise.
    if (!blind && shrink()) {
      spread();
      noise.map = pixel_map();
    }
    apply_quantisation(noise);
    return noise;
  }

 private:
  // Calls body(tile, u, v) for the pixels of every tile, thinned out.
  template <typename Body>
  void for_places(const Body& body) {
    parallel_for(tiles_.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const int u0 = static_cast<int>(k % static_cast<std::size_t>(tiles_.width())) * side_;
        const int v0 = static_cast<int>(k / static_cast<std::size_t>(tiles_.width())) * side_;
        for (int v = v0; v < std::min(v0 + side_, view_.height()); v += stride_)
          for (int u = u0; u < std::min(u0 + side_, view_.width()); u += stride_)
            body(tiles_[k], u, v);
      }
    });
  }

  void collect(Stencil stencil) {
    for (Tile& tile : tiles_) tile.differences.clear();
    for_places([&](Tile& tile, int u, int v) {
      const auto add = [&](double difference) {
        if (!(difference == difference)) return;
        const double metric = view_.camera.ray(u, v).direction.norm();
        const double size = std::abs(difference) * metric;
        const bool rounding = size <= kRounding * metric * view_.range(u, v);
        tile.differences.push_back(rounding && !keep_rounding_ ? 0.0f : static_cast<float>(size));
      };
      if (stencil == Stencil::kSquare) {
        if (u + 2 < view_.width() && v + 2 < view_.height()) add(square_difference(view_, u, v));
        return;
      }
      const int du = stencil == Stencil::kAlongRows ? 1 : 0, dv = 1 - du;
      if (u + 3 * du < view_.width() && v + 3 * dv < view_.height())
        add(line_difference(view_, u, v, du, dv));
    });
  }

  std::size_t count() const {
    std::size_t sum = 0;
    for (const Tile& tile : tiles_) sum += tile.differences.size();
    return sum;
  }

  // Samples at places where a difference could have been.
  std::size_t places() const {
    return view_.sample_count() / static_cast<std::size_t>(stride_ * stride_);
  }

  double sigma_of_all() const {
    std::vector<float> all;
    for (const Tile& tile : tiles_)
      all.insert(all.end(), tile.differences.begin(), tile.differences.end());
    return all.empty() ? 0.0 : core_sigma(all);
  }

  // With what is rounding, which is all that interpolated samples show.
  double sigma_of(Stencil stencil) const {
    TiledNoise other(view_, quantisation_, /*keep_rounding=*/true);
    other.collect(stencil);
    return other.sigma_of_all();
  }

  // Whether the squares show next to none of the noise: some sensors interpolate along one
  // direction.
  bool squares_see_nothing() const {
    return sigma_of(Stencil::kSquare) <
           kSeesNothing * std::max(sigma_of(Stencil::kAlongRows), sigma_of(Stencil::kAlongColumns));
  }
  Stencil louder_lines() const {
    return sigma_of(Stencil::kAlongRows) >= sigma_of(Stencil::kAlongColumns)
               ? Stencil::kAlongRows
               : Stencil::kAlongColumns;
  }

  // Of the logarithm of the deviation that so many differences give.
  double variance_of(std::size_t differences) const {
    return (stride_ > 1 ? kThinnedLogVariance : kLogVariance) / static_cast<double>(differences);
  }

  void find_tile_sigmas() {
    parallel_for(tiles_.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        Tile& tile = tiles_[k];
        if (variance_of(tile.differences.size()) > kLogVariance / kFewestInTile) continue;
        const double sigma = core_sigma(tile.differences);
        if (!(sigma > 0.0)) continue;
        tile.log_sigma = std::log(sigma);
        tile.variance = variance_of(tile.differences.size());
      }
    });
  }

  // Draws the logarithms to their mean as far as their scatter is chance (empirical Bayes). False
  // where all of it may be.
  bool shrink() {
    double weights = 0.0, mean = 0.0, squares = 0.0, count = 0.0;
    for (const Tile& tile : tiles_) {
      if (!tile.known()) continue;
      weights += 1.0 / tile.variance;
      mean += tile.log_sigma / tile.variance;
      count += 1.0;
    }
    if (count < 2.0) return false;
    mean /= weights;
    for (const Tile& tile : tiles_)
      if (tile.known()) squares += std::pow(tile.log_sigma - mean, 2) / tile.variance;
    // Chi squared of count - 1 degrees of freedom; four of its standard deviations beyond its mean.
    const double degrees = count - 1.0;
    if (squares <= degrees + 4.0 * std::sqrt(2.0 * degrees)) return false;
    const double spread = (squares - degrees) / weights;
    if (spread < kLeastSpread * kLeastSpread) return false;
    for (Tile& tile : tiles_)
      if (tile.known())
        tile.log_sigma = mean + (tile.log_sigma - mean) * spread / (spread + tile.variance);
    return true;
  }

  // Tiles without a noise of their own take the mean of those around them, ring by ring.
  void spread() {
    for (bool any = true; any;) {
      any = false;
      Grid<Tile> next = tiles_;
      for (int y = 0; y < tiles_.height(); ++y) {
        for (int x = 0; x < tiles_.width(); ++x) {
          if (tiles_(x, y).known()) continue;
          double sum = 0.0, count = 0.0;
          for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
              if (!tiles_.contains(x + dx, y + dy) || !tiles_(x + dx, y + dy).known()) continue;
              sum += tiles_(x + dx, y + dy).log_sigma;
              count += 1.0;
            }
          }
          if (count == 0.0) continue;
          next(x, y).log_sigma = sum / count;
          next(x, y).variance = 1.0;
          any = true;
        }
      }
      tiles_ = std::move(next);
    }
  }

  // Bilinear between the middles of the tiles.
  Grid<float> pixel_map() const {
    struct Place {
      int first, second;
      double share_of_second;
    };
    const auto place = [&](int pixel, int tiles) {
      const double at = (pixel + 0.5) / side_ - 0.5;
      const double clamped = std::clamp(at, 0.0, static_cast<double>(tiles - 1));
      const int first = std::min(static_cast<int>(clamped), std::max(0, tiles - 2));
      return Place{first, std::min(first + 1, tiles - 1), clamped - first};
    };
    Grid<double> along_rows(view_.width(), tiles_.height());
    for (int y = 0; y < tiles_.height(); ++y) {
      for (int u = 0; u < view_.width(); ++u) {
        const Place x = place(u, tiles_.width());
        along_rows(u, y) = std::lerp(tiles_(x.first, y).log_sigma, tiles_(x.second, y).log_sigma,
                                     x.share_of_second);
      }
    }
    Grid<float> map(view_.width(), view_.height(), 0.0f);
    parallel_rows(view_.height(), [&](int v) {
      const Place y = place(v, tiles_.height());
      for (int u = 0; u < view_.width(); ++u)
        map(u, v) = static_cast<float>(std::exp(
            std::lerp(along_rows(u, y.first), along_rows(u, y.second), y.share_of_second)));
    });
    return map;
  }

  // A rounded range errs by step / sqrt(12), even where all its neighbours err alike.
  void apply_quantisation(RangeNoise& noise) const {
    if (!quantisation_.exists() && noise.map.empty()) return;
    if (noise.map.empty())
      noise.map = {view_.width(), view_.height(), static_cast<float>(noise.sigma)};
    std::vector<float> sigmas, steps;
    for (int v = 0; v < view_.height(); ++v) {
      for (int u = 0; u < view_.width(); ++u) {
        if (!view_.has_sample(u, v)) continue;
        steps.push_back(step_at(u, v));
        noise.map(u, v) = std::max(noise.map(u, v), steps.back() / std::sqrt(12.0f));
        sigmas.push_back(noise.map(u, v));
      }
    }
    const auto [lowest, highest] = std::minmax_element(sigmas.begin(), sigmas.end());
    const bool alike = *highest <= *lowest * (1.0f + static_cast<float>(kLeastSpread));
    noise.sigma = median(sigmas);
    noise.step = median(steps);
    if (alike) noise.map = {};
  }

  float step_at(int u, int v) const {
    if (!quantisation_.exists()) return 0.0f;
    const double metric = view_.camera.ray(u, v).direction.norm();
    return static_cast<float>(quantisation_.step_at(view_.range(u, v), metric));
  }

  const RangeView& view_;
  const RangeQuantisation& quantisation_;
  const bool keep_rounding_;
  int side_ = kLeastTile;
  int stride_ = 1;  // Of the differences that are used [samples].
  Grid<Tile> tiles_;
};

}  // namespace

RangeNoise estimate_range_noise(const RangeView& view) {
  const RangeQuantisation quantisation = find_quantisation(view);
  return TiledNoise(view, quantisation).estimate();
}

}  // namespace relief
