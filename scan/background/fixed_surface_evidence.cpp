#include "scan/background/fixed_surface_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

// Samples of a set that are carried into other views; bounds the time. Fractions are told to 0.009.
constexpr std::size_t kProbes = 3000;
constexpr std::size_t kOtherViews = 16;  // at most, for each sample; bounds the time
// Of the radius of what moves, but of a sample's distance from the camera where that is less:
// errors of poses that turn the camera carry near samples less far.
constexpr double kFar = 0.1;
// Poses that carry a sample less far than that leave it where it stands, and tell nothing [kFar].
constexpr double kTelling = 2.0;
constexpr std::size_t kEnough = 200;  // Carried samples: a share of 0.5 is told to 0.035.
// Of all that are seen, more than noise and edges make: 0.002 of floors that turn in themselves,
// 0.2 where walls stand round them.
constexpr double kTellingPart = 0.05;
constexpr double kEdgeOfImage = 0.02;  // part of the moving pixels that may lie beyond a side
constexpr double kIsland = 0.05;  // part of a view's moving samples: less is no piece of the object

// A sample of a view of the stack.
struct Probe {
  std::size_t view;
  int u, v;
};

// Some of the samples of one set, evenly over all of them.
class ProbeSet {
 public:
  explicit ProbeSet(std::size_t samples) : stride_(std::max<std::size_t>(1, samples / kProbes)) {}
  void offer(const Probe& probe) {
    if (seen_++ % stride_ == 0) probes_.push_back(probe);
  }
  const std::vector<Probe>& probes() const { return probes_; }

 private:
  std::size_t stride_, seen_ = 0;
  std::vector<Probe> probes_;
};

// Root mean square distance from their centre of the samples that move, view by view, in the
// middle of all views [unit].
double moving_radius(const std::vector<const RangeView*>& views, const DepthStack& stack,
                     const std::vector<Probe>& probes) {
  double squares = 0.0, all = 0.0;
  for (std::size_t begin = 0; begin < probes.size();) {
    std::size_t end = begin;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double sum_squares = 0.0;
    while (end < probes.size() && probes[end].view == probes[begin].view) {
      const Eigen::Vector3d point =
          views[stack.views[probes[end].view]]->point(probes[end].u, probes[end].v);
      sum += point;
      sum_squares += point.squaredNorm();
      ++end;
    }
    const double count = static_cast<double>(end - begin);
    squares += std::max(0.0, sum_squares - sum.squaredNorm() / count);
    all += count;
    begin = end;
  }
  return all > 0.0 ? std::sqrt(squares / all) : 0.0;
}

enum class Sight { kNothing, kSame, kStanding, kThrough };

// Whether a view has a sample at a point of its frame, give or take `far` in all directions, or
// sees through it. `kinds`: of its samples.
Sight look_at(const RangeView& view, const Grid<SampleKind>& kinds, const Eigen::Vector3d& point,
              double far) {
  constexpr int kSteps = 3;  // to each side; bounds the time
  const auto pixel = view.camera.project(point);
  if (!pixel) return Sight::kNothing;
  const int u = static_cast<int>(std::lround(pixel->x()));
  const int v = static_cast<int>(std::lround(pixel->y()));
  if (!view.has_sample(u, v)) return Sight::kNothing;
  const auto behind = [&](int at_u, int at_v) {
    const Ray ray = view.camera.ray(at_u, at_v);
    return (view.range(at_u, at_v) - ray.range_of(point)) * ray.direction.norm();
  };
  const double here = behind(u, v);
  if (here < -far) return Sight::kNothing;
  const auto same = [&](int at_u, int at_v) {
    return kinds(at_u, at_v) == SampleKind::kStanding ? Sight::kStanding : Sight::kSame;
  };
  if (here <= far) return same(u, v);
  const Ray ray = view.camera.ray(u, v), beside = view.camera.ray_at(u + 1.0, v + 1.0);
  const double footprint =
      (beside.at(beside.range_of(point)) - ray.at(ray.range_of(point))).norm() / std::sqrt(2.0);
  const double step = std::max(1.0, far / (kSteps * footprint));
  for (int j = -kSteps; j <= kSteps; ++j) {
    for (int i = -kSteps; i <= kSteps; ++i) {
      const int at_u = u + static_cast<int>(std::lround(i * step));
      const int at_v = v + static_cast<int>(std::lround(j * step));
      if (view.has_sample(at_u, at_v) && std::abs(behind(at_u, at_v)) <= far)
        return same(at_u, at_v);
    }
  }
  return Sight::kThrough;
}

// Carries the probes into other views. `radius`: of what moves [unit].
CarriedSamples test_poses(const std::vector<const RangeView*>& views, const DepthStack& stack,
                          const std::vector<Grid<SampleKind>>& kinds,
                          const std::vector<Probe>& probes, double radius) {
  const std::size_t step = std::max<std::size_t>(1, stack.size() / kOtherViews);
  const auto add = [](CarriedSamples a, const CarriedSamples& b) {
    return CarriedSamples{a.confirmed + b.confirmed, a.refuted + b.refuted,
                          a.in_itself + b.in_itself};
  };
  constexpr std::size_t kAtOnce = 128;  // Of one piece of work; changes no result.
  std::vector<CarriedSamples> parts((probes.size() + kAtOnce - 1) / kAtOnce);
  parallel_for(probes.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    CarriedSamples& part = parts[begin / kAtOnce];
    for (std::size_t k = begin; k < end; ++k) {
      const RangeView& from = *views[stack.views[probes[k].view]];
      const Eigen::Vector3d in_view = from.point(probes[k].u, probes[k].v);
      const Eigen::Vector3d in_world = from.world_from_view * in_view;
      const double far = kFar * std::min(radius, in_view.norm());
      for (std::size_t other = probes[k].view % step; other < stack.size(); other += step) {
        if (other == probes[k].view) continue;
        const RangeView& to = *views[stack.views[other]];
        const Eigen::Vector3d point = to.world_from_view.inverse() * in_world;
        if ((point - in_view).norm() < kTelling * far) continue;
        switch (look_at(to, kinds[other], point, far)) {
          case Sight::kThrough:
            ++part.refuted;
            break;
          case Sight::kSame:
            ++part.confirmed;
            break;
          case Sight::kStanding:
            ++part.in_itself;
            ++part.confirmed;
            break;
          case Sight::kNothing:
            break;
        }
      }
    }
  });
  CarriedSamples all;
  for (const CarriedSamples& part : parts) all = add(all, part);
  return all;
}

// How often each column and row of the image has a sample of one set.
struct Extent {
  std::vector<std::size_t> columns, rows;
  std::size_t count = 0;

  Extent(int width, int height)
      : columns(static_cast<std::size_t>(width), 0), rows(static_cast<std::size_t>(height), 0) {}
  void add(int u, int v) {
    ++columns[static_cast<std::size_t>(u)];
    ++rows[static_cast<std::size_t>(v)];
    ++count;
  }
  // The first and last place with all but a small part of the samples between them.
  static std::pair<int, int> range(const std::vector<std::size_t>& places, std::size_t count) {
    const double beyond = kEdgeOfImage * static_cast<double>(count);
    std::size_t sum = 0, first = 0, last = places.size();
    while (first < places.size() && static_cast<double>(sum + places[first]) <= beyond)
      sum += places[first++];
    sum = 0;
    while (last > first && static_cast<double>(sum + places[last - 1]) <= beyond)
      sum += places[--last];
    return {static_cast<int>(first), static_cast<int>(last)};
  }
};

int sides_beyond(const Extent& piece, const Extent& moving) {
  int sides = 0;
  for (const auto& [outer, inner] :
       {std::pair{Extent::range(piece.columns, piece.count),
                  Extent::range(moving.columns, moving.count)},
        {Extent::range(piece.rows, piece.count), Extent::range(moving.rows, moving.count)}})
    sides += (outer.first <= inner.first ? 1 : 0) + (outer.second >= inner.second ? 1 : 0);
  return sides;
}

// The moving samples of a view without islands: noise makes them anywhere, also in the middle of
// what stands still.
Grid<std::uint8_t> moving_object(const Grid<SampleKind>& kinds, const GridEdges& edges) {
  const auto moving = [&](int u, int v) { return kinds(u, v) == SampleKind::kMoving; };
  const auto at = [&](int u, int v) { return static_cast<std::uint32_t>(kinds.index(u, v)); };
  DisjointSets sets(kinds.size());
  std::size_t count = 0;
  for (int v = 0; v < kinds.height(); ++v) {
    for (int u = 0; u < kinds.width(); ++u) {
      if (!moving(u, v)) continue;
      ++count;
      if (edges.right(u, v) && moving(u + 1, v)) sets.join(at(u, v), at(u + 1, v));
      if (edges.down(u, v) && moving(u, v + 1)) sets.join(at(u, v), at(u, v + 1));
    }
  }
  std::vector<std::size_t> sizes(kinds.size(), 0);
  for (std::uint32_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == SampleKind::kMoving) ++sizes[sets.find(i)];
  const double least = kIsland * static_cast<double>(count);
  Grid<std::uint8_t> object(kinds.width(), kinds.height(), 0);
  for (std::uint32_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == SampleKind::kMoving && static_cast<double>(sizes[sets.find(i)]) >= least)
      object[i] = 1;
  return object;
}

}  // namespace

bool CarriedSamples::enough() const { return confirmed + refuted >= kEnough; }
double CarriedSamples::refuted_share() const {
  const double all = static_cast<double>(confirmed + refuted);
  return all > 0.0 ? static_cast<double>(refuted) / all : 0.0;
}
double CarriedSamples::telling_refuted_share() const {
  const double telling = static_cast<double>(confirmed - in_itself + refuted);
  const bool tells = telling >= static_cast<double>(kEnough) &&
                     telling >= kTellingPart * static_cast<double>(confirmed + refuted);
  return tells ? static_cast<double>(refuted) / telling : 0.0;
}
double PieceEvidence::attached_share() const {
  return beside > 0 ? static_cast<double>(attached) / static_cast<double>(beside) : 0.0;
}

FixedSurfaceEvidence gather_evidence(const std::vector<const RangeView*>& views,
                                     const DepthStack& stack, const FixedSurface& surface,
                                     const std::vector<Grid<SampleKind>>& kinds,
                                     const std::vector<GridEdges>& edges) {
  FixedSurfaceEvidence evidence;
  evidence.pieces.resize(surface.pieces);
  const int width = stack.camera.width(), height = stack.camera.height();
  std::vector<Extent> extents(surface.pieces, Extent(width, height));
  Extent moving_extent(width, height);
  evidence.has_poses = true;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    evidence.has_poses = evidence.has_poses && views[stack.views[i]]->pose != PoseKind::kAbsent &&
                         views[stack.views[i]]->camera.can_project();
    std::vector<bool> seen(surface.pieces, false);
    const auto object = moving_object(kinds[i], edges[i]);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        if (kinds[i](u, v) == SampleKind::kMoving) {
          ++evidence.moving;
          moving_extent.add(u, v);
        }
        if (kinds[i](u, v) != SampleKind::kStanding) continue;
        ++evidence.fixed;
        const auto number = static_cast<std::size_t>(surface.piece(u, v));
        PieceEvidence& piece = evidence.pieces[number];
        ++piece.samples;
        seen[number] = true;
        extents[number].add(u, v);
        for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          if (!object.contains(u + du, v + dv) || !object(u + du, v + dv)) continue;
          ++piece.beside;
          piece.attached += edges[i].connected(u, v, du, dv) ? 1 : 0;
        }
      }
    }
    for (std::size_t k = 0; k < seen.size(); ++k) evidence.pieces[k].views += seen[k] ? 1 : 0;
  }
  for (std::size_t k = 0; k < surface.pieces; ++k)
    evidence.pieces[k].sides = sides_beyond(extents[k], moving_extent);
  if (!evidence.has_poses || surface.pieces == 0) return evidence;

  std::vector<ProbeSet> sets;
  for (const PieceEvidence& piece : evidence.pieces) sets.emplace_back(piece.samples);
  ProbeSet moving(evidence.moving);
  for (std::size_t i = 0; i < stack.size(); ++i)
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) {
        if (kinds[i](u, v) == SampleKind::kMoving) moving.offer({i, u, v});
        if (kinds[i](u, v) == SampleKind::kStanding)
          sets[static_cast<std::size_t>(surface.piece(u, v))].offer({i, u, v});
      }
  const double radius = moving_radius(views, stack, moving.probes());
  evidence.moving_poses = test_poses(views, stack, kinds, moving.probes(), radius);
  for (std::size_t k = 0; k < surface.pieces; ++k)
    evidence.pieces[k].poses = test_poses(views, stack, kinds, sets[k].probes(), radius);
  return evidence;
}

}  // namespace relief
