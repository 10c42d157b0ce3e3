#include "scan/grid/binned_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "scan/base/median.h"

namespace relief {

namespace {

constexpr int kBetweenRows = 8;  // that tell the spacing; bounds the time

// Of the pixels of a large one, to be on the same surface as the middle one: surfaces up to 72
// degrees steep are within, of [widths of the large pixel].
constexpr double kSameSurface = 1.5;
constexpr std::size_t kFewest = 3;  // Samples that a plane goes through.

struct Pixel {
  int u, v;
};

// The samples of a large pixel that are on one surface.
std::vector<Pixel> samples_of(const RangeView& view, int factor, int u, int v) {
  std::vector<Pixel> pixels;
  std::vector<double> ranges;
  for (int j = v * factor; j < (v + 1) * factor; ++j) {
    for (int i = u * factor; i < (u + 1) * factor; ++i) {
      if (!view.has_sample(i, j)) continue;
      pixels.push_back({i, j});
      ranges.push_back(view.range(i, j));
    }
  }
  const auto half = static_cast<std::size_t>((factor * factor + 1) / 2);
  if (pixels.size() < half) return {};
  const double middle = median(std::move(ranges));
  const Ray left = view.camera.ray(u * factor, v * factor);
  const Ray right = view.camera.ray(u * factor + factor - 1, v * factor);
  const double width = (right.at(middle) - left.at(middle)).norm() * factor / (factor - 1);
  const double most = kSameSurface * width / left.direction.norm();
  std::erase_if(pixels, [&](const Pixel& pixel) {
    return std::abs(view.range(pixel.u, pixel.v) - middle) > most;
  });
  return pixels.size() < half ? std::vector<Pixel>() : pixels;
}

// The range in the middle of a large pixel. Where one surface fills it, that is their mean.
double middle_range(const RangeView& view, const std::vector<Pixel>& pixels, double middle_u,
                    double middle_v) {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Pixel& pixel : pixels) {
    const Eigen::Vector3d place(1.0, pixel.u - middle_u, pixel.v - middle_v);
    squares += place * place.transpose();
    sum += view.range(pixel.u, pixel.v) * place;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(squares);
  if (pixels.size() < kFewest || !solver.isInvertible()) return sum[0] / squares(0, 0);
  return solver.solve(sum)[0];
}

Eigen::Vector3f mean_normal(const RangeView& view, const std::vector<Pixel>& pixels) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Pixel& pixel : pixels)
    if (view.has_normal(pixel.u, pixel.v)) sum += view.normals(pixel.u, pixel.v);
  if (sum.squaredNorm() > 0.0f) return sum.normalized();
  return Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
}

float mean_confidence(const RangeView& view, const std::vector<Pixel>& pixels) {
  float sum = 0.0f;
  for (const Pixel& pixel : pixels) sum += view.confidence(pixel.u, pixel.v);
  return sum / static_cast<float>(pixels.size());
}

// Of the mean, NaN where none is known.
float deviation_of_mean(const RangeView& view, const std::vector<Pixel>& pixels) {
  double squares = 0.0, sum = 0.0, count = 0.0;
  for (const Pixel& pixel : pixels) {
    const double deviation = view.deviation(pixel.u, pixel.v);
    if (!(deviation == deviation)) continue;
    squares += deviation * deviation;
    sum += deviation;
    ++count;
  }
  return static_cast<float>((view.samples == SampleOrigin::kRefined ? sum : std::sqrt(squares)) /
                            count);
}

Colour mean_colour(const RangeView& view, const std::vector<Pixel>& pixels) {
  std::array<double, 3> sum{};
  for (const Pixel& pixel : pixels)
    for (std::size_t k = 0; k < 3; ++k) sum[k] += view.colours(pixel.u, pixel.v)[k];
  Colour mean;
  for (std::size_t k = 0; k < 3; ++k)
    mean[k] = static_cast<std::uint8_t>(std::lround(sum[k] / static_cast<double>(pixels.size())));
  return mean;
}

// Of the view with larger pixels, all without samples.
RangeView empty_view(const RangeView& view, const Camera& camera) {
  RangeView binned;
  binned.name = view.name;
  binned.camera = camera;
  binned.world_from_view = view.world_from_view;
  binned.pose = view.pose;
  binned.samples = view.samples;
  const int width = camera.width(), height = camera.height();
  const auto nothing = static_cast<float>(kNoSample);
  binned.range = Grid<double>(width, height, kNoSample);
  if (view.has_normals())
    binned.normals = Grid<Eigen::Vector3f>(width, height, Eigen::Vector3f::Constant(nothing));
  if (!view.confidence.empty()) binned.confidence = Grid<float>(width, height, 0.0f);
  if (!view.deviation.empty()) binned.deviation = Grid<float>(width, height, nothing);
  if (!view.colours.empty()) binned.colours = Grid<Colour>(width, height, Colour{});
  return binned;
}

}  // namespace

double rough_spacing(const RangeView& view) {
  std::vector<double> distances;
  for (int v = 0; v < view.height(); v += kBetweenRows)
    for (int u = 0; u + 1 < view.width(); ++u)
      if (view.has_sample(u, v) && view.has_sample(u + 1, v))
        distances.push_back((view.point(u + 1, v) - view.point(u, v)).norm());
  return median(std::move(distances));
}

std::optional<RangeView> bin_view(const RangeView& view, int factor) {
  const auto camera = view.camera.binned(factor);
  if (!camera) return std::nullopt;
  RangeView binned = empty_view(view, *camera);
  for (int v = 0; v < binned.height(); ++v) {
    for (int u = 0; u < binned.width(); ++u) {
      const auto pixels = samples_of(view, factor, u, v);
      if (pixels.empty()) continue;
      const double middle = (factor - 1) / 2.0;
      binned.range(u, v) = middle_range(view, pixels, u * factor + middle, v * factor + middle);
      if (view.has_normals()) binned.normals(u, v) = mean_normal(view, pixels);
      if (!view.confidence.empty()) binned.confidence(u, v) = mean_confidence(view, pixels);
      if (!view.deviation.empty()) binned.deviation(u, v) = deviation_of_mean(view, pixels);
      if (!view.colours.empty()) binned.colours(u, v) = mean_colour(view, pixels);
    }
  }
  return binned;
}

}  // namespace relief
