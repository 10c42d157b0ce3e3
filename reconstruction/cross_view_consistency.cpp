#include "relief/reconstruction/cross_view_consistency.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "reconstruction/range_correction.h"
#include "relief/scan/discontinuities.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/grid_normals.h"
#include "scan/grid/range_noise.h"
#include "scan/views/view_projection.h"

namespace relief::reconstruction {

namespace {

constexpr std::size_t kFewestOthers = 2;  // One alone may be the one that is wrong.
// Beyond so many sample spacings lies another surface. Larger takes the far side of thin parts for
// the same; smaller believes glare, whose noise of three spacings reaches nine.
constexpr double kReach = 10.0;
// Cosine of incidence: at 73 degrees the spacing is 3.3 times as wide, and ranges tell little.
constexpr double kSteepest = 0.3;
// Local spacing of another view against its own: coarser ones show detail of two samples as flat.
constexpr double kCoarsest = 2.0;
constexpr int kHalfWindow = 2;       // [samples]
constexpr int kFewestInWindow = 13;  // Half of 5 x 5: fewer are far off by chance.
// Mean squares up to two deviations are left alone, (H16): the mean of 25 of white noise is 1, with
// a deviation of 0.28 (sqrt(2 / 25)).
constexpr double kTypical = 4.0;

// A view with all that comparing needs to know of it, in its own frame.
struct ComparedView {
  const RangeView* view = nullptr;
  std::optional<ViewProjection> projection;  // None: points cannot be found in it.
  RangeNoise noise;
  GridEdges edges;
  Grid<Eigen::Vector3f> estimated_normals;  // Of views without measured ones.
  Grid<float> local_spacing;  // Longest step to a neighbour on the surface; 0 where there is none.
  double spacing = 0.0;
  RigidMotion view_from_world;

  explicit ComparedView(const RangeView& of) : view(&of) {
    if (auto created = ViewProjection::create(of)) projection = std::move(*created);
    noise = estimate_range_noise(of);
    edges = connect_samples(of, noise);
    const Grid<Eigen::Vector3d> points = points_of(of);
    spacing = sample_spacing(points, edges);
    measure_local_spacing(points);
    view_from_world = of.world_from_view.inverse();
    if (!of.has_normals()) {
      estimated_normals = estimate_normals(of, edges, {});
    }
  }

  const Grid<Eigen::Vector3f>& normals() const {
    return view->has_normals() ? view->normals : estimated_normals;
  }
  // Noise at a pixel against that of a typical one.
  double relative_noise(int u, int v) const {
    return noise.map.empty() ? 1.0 : noise.sigma_at(u, v) / noise.sigma;
  }

 private:
  void measure_local_spacing(const Grid<Eigen::Vector3d>& points) {
    local_spacing = {points.width(), points.height(), 0.0f};
    parallel_rows(points.height(), [&](int v) {
      for (int u = 0; u < points.width(); ++u) {
        double longest = 0.0;
        for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
          if (edges.connected(u, v, du, dv))
            longest = std::max(longest, (points(u + du, v + dv) - points(u, v)).squaredNorm());
        local_spacing(u, v) = static_cast<float>(std::sqrt(longest));
      }
    });
  }
};

struct SurfaceSample {
  Eigen::Vector3d point, normal;  // World frame.
  double local_spacing = 0.0;     // [unit]
};

// How far in front of the surface of `other` a sample lies along the sample's normal [unit],
// negative behind; nothing where `other` does not tell.
std::optional<double> distance_to(const ComparedView& other, const SurfaceSample& sample,
                                  double reach) {
  const Eigen::Vector3d point = other.view_from_world * sample.point;
  const auto pixel = other.projection->pixel_of(point);
  if (!pixel) return std::nullopt;
  const int u = static_cast<int>(std::floor(pixel->x()));
  const int v = static_cast<int>(std::floor(pixel->y()));
  if (!other.edges.connected_quad(u, v) ||
      other.local_spacing(u, v) > kCoarsest * sample.local_spacing)
    return std::nullopt;
  const double s = pixel->x() - u, t = pixel->y() - v;
  const Grid<double>& range = other.view->range;
  const double seen = (1.0 - t) * ((1.0 - s) * range(u, v) + s * range(u + 1, v)) +
                      t * ((1.0 - s) * range(u, v + 1) + s * range(u + 1, v + 1));
  const Ray ray = other.view->camera.ray_at(pixel->x(), pixel->y());
  const double own = (point - ray.origin).dot(ray.direction) / ray.direction.squaredNorm();
  const double facing = -(other.view_from_world.linear() * sample.normal).dot(ray.direction);
  if (facing < kSteepest * ray.direction.norm()) return std::nullopt;
  const double distance = (seen - own) * facing;
  if (std::abs(distance) > reach) return std::nullopt;
  return distance;
}

// The two middle distances; the one in the middle twice where their number is odd. Sorts them.
struct MiddleDistances {
  double below, above;

  explicit MiddleDistances(std::vector<double>& distances) {
    std::sort(distances.begin(), distances.end());
    below = distances[(distances.size() - 1) / 2];
    above = distances[distances.size() / 2];
  }
  double median() const { return 0.5 * (below + above); }
  // The least that half of the distances agree on; 0 where they do not agree on the sign.
  double agreed() const {
    if (below * above <= 0.0) return 0.0;
    return std::abs(below) < std::abs(above) ? below : above;
  }
};

// NaN where too few other views tell.
struct Distances {
  Grid<float> agreed;      // In units of the noise map.
  Grid<float> correction;  // Of the range, to the middle of the others.
};

Distances distances_to_others(const ComparedView& own_view,
                              const std::vector<const ComparedView*>& others) {
  const RangeView& view = *own_view.view;
  const Grid<float> unknown(view.width(), view.height(), static_cast<float>(kNoSample));
  Distances result{unknown, unknown};
  parallel_rows(view.height(), [&](int v) {
    std::vector<double> distances;
    for (int u = 0; u < view.width(); ++u) {
      const Eigen::Vector3d normal = own_view.normals()(u, v).cast<double>();
      if (!view.has_sample(u, v) || !(normal.x() == normal.x())) continue;
      const SurfaceSample sample{view.world_from_view * view.point(u, v),
                                 view.world_from_view.linear() * normal,
                                 own_view.local_spacing(u, v)};
      distances.clear();
      for (const ComparedView* other : others)
        if (const auto distance = distance_to(*other, sample, kReach * own_view.spacing))
          distances.push_back(*distance);
      if (distances.size() < kFewestOthers) continue;
      const MiddleDistances middle(distances);
      result.agreed(u, v) = static_cast<float>(middle.agreed() / own_view.relative_noise(u, v));
      const Eigen::Vector3d direction = view.camera.ray(u, v).direction;
      const double facing = -normal.dot(direction);
      if (facing > kSteepest * direction.norm())
        result.correction(u, v) = static_cast<float>(middle.median() / facing);
    }
  });
  return result;
}

// Of the distances that are not 0; at least the noise of the ranges.
double robust_deviation(const Grid<float>& distances, const RangeNoise& noise) {
  std::vector<float> sizes;
  for (const float distance : distances)
    if (std::abs(distance) > 0.0f) sizes.push_back(std::abs(distance));
  return std::max(kSigmaPerMedian * double{median(sizes)}, noise.sigma);
}

// The square of the distances in deviations, averaged over the window round a pixel; 0 where too
// few are known.
double mean_square(const Grid<float>& distances, int u, int v, double deviation) {
  double sum = 0.0;
  int count = 0;
  for (int y = v - kHalfWindow; y <= v + kHalfWindow; ++y) {
    for (int x = u - kHalfWindow; x <= u + kHalfWindow; ++x) {
      if (!distances.contains(x, y) || !(distances(x, y) == distances(x, y))) continue;
      const double ratio = double{distances(x, y)} / deviation;
      sum += ratio * ratio;
      ++count;
    }
  }
  return count >= kFewestInWindow ? sum / count : 0.0;
}

struct Comparison {
  ViewConsistency consistency;
  Grid<float> factor;      // Of the confidence, equation (H16).
  Grid<float> correction;  // Of the range; NaN: none.
};

Comparison compare(const ComparedView& own_view, const std::vector<const ComparedView*>& others) {
  Comparison comparison;
  const RangeView& view = *own_view.view;
  comparison.factor = {view.width(), view.height(), 1.0f};
  if (others.size() < kFewestOthers) return comparison;
  Distances found = distances_to_others(own_view, others);
  const Grid<float>& distances = found.agreed;
  ViewConsistency& consistency = comparison.consistency;
  consistency.compared = static_cast<std::size_t>(
      std::count_if(distances.begin(), distances.end(), [](float x) { return x == x; }));
  const double deviation = robust_deviation(distances, own_view.noise);
  if (consistency.compared == 0 || !(deviation > 0.0)) return comparison;
  consistency.deviation = deviation;
  parallel_rows(view.height(), [&](int v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const double square = mean_square(distances, u, v, deviation);
      if (square > kTypical) comparison.factor(u, v) = static_cast<float>(kTypical / square);
      const double ratio = double{distances(u, v)} / deviation;
      if (!(square > kTypical && ratio * ratio > kTypical))
        found.correction(u, v) = static_cast<float>(kNoSample);
    }
  });
  comparison.correction = std::move(found.correction);
  consistency.contradicted = static_cast<std::size_t>(std::count_if(
      comparison.factor.begin(), comparison.factor.end(), [](float x) { return x < 1.0f; }));
  return comparison;
}

// Deviations hold the confidence.
void lower_confidence(const Grid<float>& factor, RangeView& view) {
  if (view.confidence.empty()) view.confidence = {view.width(), view.height(), 1.0f};
  for (std::size_t i = 0; i < factor.size(); ++i) {
    view.confidence[i] *= factor[i];
    if (!view.deviation.empty()) view.deviation[i] /= std::sqrt(factor[i]);
  }
}

Result<std::vector<ViewConsistency>> weigh(const std::vector<registration::PairFit>& pairs,
                                           const CrossViewOptions& options,
                                           std::vector<RangeView>& views,
                                           const Progress& progress) {
  std::vector<ComparedView> compared;
  compared.reserve(views.size());
  for (const RangeView& view : views) compared.emplace_back(view);
  std::vector<std::vector<const ComparedView*>> others(views.size());
  for (const registration::PairFit& pair : pairs) {
    if (compared[pair.b].projection) others[pair.a].push_back(&compared[pair.b]);
    if (compared[pair.a].projection) others[pair.b].push_back(&compared[pair.a]);
  }
  std::vector<Comparison> comparisons;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double done = static_cast<double>(i) / static_cast<double>(views.size());
    if (!report_progress(progress, done, "comparing views"))
      return Error{ErrorKind::kInterrupted, "comparing views: stopped on request"};
    comparisons.push_back(compare(compared[i], others[i]));
  }
  std::vector<ViewConsistency> found;
  for (std::size_t i = 0; i < views.size(); ++i) {
    found.push_back(comparisons[i].consistency);
    if (found.back().contradicted == 0) continue;
    lower_confidence(comparisons[i].factor, views[i]);
    if (options.correct)
      found.back().corrected = correct_ranges(comparisons[i].correction, views[i]);
  }
  return found;
}

}  // namespace

Result<std::vector<ViewConsistency>> weigh_by_consistency(
    const std::vector<registration::PairFit>& pairs, const CrossViewOptions& options,
    std::vector<RangeView>& views, const Context& context) {
  return run_in(context, [&] { return weigh(pairs, options, views, context.progress); });
}

}  // namespace relief::reconstruction
