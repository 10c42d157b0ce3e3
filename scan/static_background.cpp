#include "scan/static_background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "scan/depth_stack.h"
#include "scan/discontinuities.h"
#include "scan/disjoint_sets.h"
#include "scan/parallel.h"
#include "scan/standing_evidence.h"
#include "scan/standing_surface.h"

namespace relief {

namespace {

constexpr std::size_t kFewestViews = 3;
constexpr double kLeastPart = 0.01;  // of the samples: less does not stand or move
constexpr double kRefuted = 0.5;     // share of refuted samples of a background
constexpr double kConfirmed = 0.2;   // and of what the poses describe
constexpr double kMostAttached = 0.05;
constexpr int kSidesBeyond = 3;
constexpr std::array<float, 4> kTolerances = {1.0f, 2.0f, 4.0f, 8.0f};  // of the stack's
constexpr double kCovered = 0.99;                                       // of the largest background
constexpr std::size_t kLargestSpeck = 9;  // samples that noise alone cuts off,
constexpr float kSpeckReach = 3.0f;       // as far from the background, in tolerances

enum class Verdict { kObject, kBackground, kUndecided };

Verdict judge(const PieceEvidence& piece, const StandingEvidence& all) {
  if (piece.views < kFewestViews) return Verdict::kObject;
  const bool poses_describe =
      all.has_poses && all.moving_poses.enough() && all.moving_poses.refuted_share() <= kConfirmed;
  if (poses_describe && piece.poses.enough()) {
    const double refuted = piece.poses.refuted_share();
    if (refuted >= kRefuted) return Verdict::kBackground;
    return refuted <= kConfirmed ? Verdict::kObject : Verdict::kUndecided;
  }
  if (piece.sides < kSidesBeyond) return Verdict::kObject;
  const bool apart = piece.beside > 0 && piece.attached_share() <= kMostAttached;
  return apart ? Verdict::kBackground : Verdict::kUndecided;
}

// Marks the samples of a view that belong to the background: those on its pieces, and others that
// hang together with them and not with the rest.
class ViewMask {
 public:
  ViewMask(const DepthStack& stack, std::size_t view, const Grid<SampleKind>& kinds,
           const StandingSurface& surface, const std::vector<Verdict>& verdicts,
           const GridEdges& edges)
      : kinds_(kinds), edges_(edges), mask_(kinds.width(), kinds.height(), 0) {
    for (std::size_t i = 0; i < kinds.size(); ++i)
      mask_[i] = kinds[i] == SampleKind::kStanding &&
                 verdicts[static_cast<std::size_t>(surface.piece[i])] == Verdict::kBackground;
    add_unknown();
    for (std::size_t i = 0; i < kinds.size(); ++i)
      near_[i] =
          std::abs(stack.depths[view][i] - surface.depth[i]) <= kSpeckReach * stack.tolerance[i];
    add_specks();
  }

  Grid<std::uint8_t> take() { return std::move(mask_); }

 private:
  // Calls `body(a, b)` for the indices of samples that are neighbours on one surface.
  template <typename Body>
  void for_each_edge(const Body& body) const {
    for (int v = 0; v < mask_.height(); ++v) {
      for (int u = 0; u < mask_.width(); ++u) {
        if (edges_.right(u, v)) body(mask_.index(u, v), mask_.index(u + 1, v));
        if (edges_.down(u, v)) body(mask_.index(u, v), mask_.index(u, v + 1));
      }
    }
  }

  // Components of samples of which few views know more, by what they are attached to.
  void add_unknown() {
    const auto unknown = [&](std::size_t i) { return kinds_[i] == SampleKind::kUnknown; };
    DisjointSets sets(mask_.size());
    for_each_edge([&](std::size_t a, std::size_t b) {
      if (unknown(a) && unknown(b))
        sets.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    });
    std::vector<std::uint32_t> to_background(mask_.size(), 0), to_others(mask_.size(), 0);
    for_each_edge([&](std::size_t a, std::size_t b) {
      if (unknown(a) == unknown(b)) return;
      const std::size_t inside = unknown(a) ? a : b, outside = unknown(a) ? b : a;
      ++(mask_[outside] ? to_background : to_others)[sets.find(static_cast<std::uint32_t>(inside))];
    });
    for (std::uint32_t i = 0; i < mask_.size(); ++i)
      if (unknown(i) && to_background[sets.find(i)] > to_others[sets.find(i)]) mask_[i] = 1;
  }

  // Small components of what is left that the background surrounds, and that are close to it: the
  // rim of the object may be cut off from it, too.
  void add_specks() {
    const auto left = [&](std::size_t i) { return kinds_[i] != SampleKind::kNone && !mask_[i]; };
    DisjointSets sets(mask_.size());
    for_each_edge([&](std::size_t a, std::size_t b) {
      if (left(a) && left(b))
        sets.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    });
    std::vector<std::uint32_t> sizes(mask_.size(), 0), beside(mask_.size(), 0),
        around(mask_.size(), 0);
    for (int v = 0; v < mask_.height(); ++v) {
      for (int u = 0; u < mask_.width(); ++u) {
        const auto i = static_cast<std::uint32_t>(mask_.index(u, v));
        if (!left(i)) continue;
        const std::uint32_t set = sets.find(i);
        ++sizes[set];
        for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          if (!mask_.contains(u + du, v + dv)) continue;
          const auto j = static_cast<std::uint32_t>(mask_.index(u + du, v + dv));
          if (kinds_[j] == SampleKind::kNone || (left(j) && sets.find(j) == set)) continue;
          ++around[set];
          beside[set] += mask_[j];
        }
      }
    }
    for (std::uint32_t i = 0; i < mask_.size(); ++i) {
      if (!left(i)) continue;
      const std::uint32_t set = sets.find(i);
      speck_[i] = near_[i] && sizes[set] <= kLargestSpeck && 2 * beside[set] > around[set];
    }
    for (std::uint32_t i = 0; i < mask_.size(); ++i)
      if (speck_[i]) mask_[i] = 1;
  }

  const Grid<SampleKind>& kinds_;
  const GridEdges& edges_;
  Grid<std::uint8_t> mask_;
  std::vector<bool> near_ = std::vector<bool>(mask_.size(), false);  // the standing surface
  std::vector<bool> speck_ = std::vector<bool>(mask_.size(), false);
};

std::size_t count(const Grid<std::uint8_t>& mask) {
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1));
}

// What is found with one tolerance.
struct Attempt {
  StandingSurface surface;
  std::vector<Grid<SampleKind>> kinds;
  std::vector<Verdict> verdicts;
  std::size_t background = 0, undecided = 0;  // Samples on such pieces.
};

Attempt attempt(const std::vector<RangeView>& views, const DepthStack& stack,
                const std::vector<GridEdges>& edges, int threads) {
  Attempt result;
  result.surface = find_standing_surface(stack, threads);
  if (result.surface.pieces == 0) return result;
  result.kinds = classify_samples(stack, result.surface, threads);
  const StandingEvidence evidence =
      gather_evidence(views, stack, result.surface, result.kinds, edges, threads);
  const double least = kLeastPart * static_cast<double>(evidence.standing + evidence.moving);
  const bool moves = static_cast<double>(evidence.moving) >= least;
  for (const PieceEvidence& piece : evidence.pieces) {
    result.verdicts.push_back(moves ? judge(piece, evidence) : Verdict::kObject);
    if (result.verdicts.back() == Verdict::kBackground) result.background += piece.samples;
    if (result.verdicts.back() == Verdict::kUndecided &&
        static_cast<double>(piece.samples) >= least)
      result.undecided += piece.samples;
  }
  return result;
}

// Noise that neighbouring samples share is larger than their differences show: wider tolerances are
// tried, and the narrowest that covers the background is taken.
Attempt best_attempt(const std::vector<RangeView>& views, DepthStack& stack,
                     const std::vector<GridEdges>& edges, int threads) {
  const Grid<float> narrow = stack.tolerance;
  const auto widen = [&](float factor) {
    for (std::size_t i = 0; i < narrow.size(); ++i) stack.tolerance[i] = factor * narrow[i];
  };
  std::vector<std::size_t> samples;
  for (const float factor : kTolerances) {
    widen(factor);
    samples.push_back(attempt(views, stack, edges, threads).background);
  }
  const double enough =
      kCovered * static_cast<double>(*std::max_element(samples.begin(), samples.end()));
  std::size_t k = 0;
  while (static_cast<double>(samples[k]) < enough) ++k;
  widen(kTolerances[k]);
  return attempt(views, stack, edges, threads);
}

void search(const std::vector<RangeView>& views, DepthStack& stack, int threads,
            StaticBackground& found) {
  const auto edges = parallel_map<GridEdges>(
      stack.size(), threads, [&](std::size_t i) { return connect_samples(views[stack.views[i]]); });
  const Attempt best = best_attempt(views, stack, edges, threads);
  found.undecided += best.undecided;
  if (best.background == 0) return;
  auto masks = parallel_map<Grid<std::uint8_t>>(stack.size(), threads, [&](std::size_t i) {
    return ViewMask(stack, i, best.kinds[i], best.surface, best.verdicts, edges[i]).take();
  });
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const std::size_t samples = count(masks[i]);
    // A view of nothing but background is left to the user.
    if (samples == 0 || samples == views[stack.views[i]].sample_count()) continue;
    found.samples += samples;
    ++found.views;
    found.masks[stack.views[i]] = std::move(masks[i]);
  }
}

}  // namespace

StaticBackground find_static_background(const std::vector<RangeView>& views, int threads) {
  StaticBackground found;
  found.masks.resize(views.size());
  if (views.size() < kFewestViews) return found;
  for (DepthStack& stack : stack_depths(views, threads))
    if (stack.size() >= kFewestViews) search(views, stack, threads, found);
  return found;
}

void remove_background(const Grid<std::uint8_t>& mask, RangeView& view) {
  for (std::size_t k = 0; k < mask.size(); ++k) {
    if (!mask[k]) continue;
    view.range[k] = kNoSample;
    if (view.has_normals())
      view.normals[k] = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
    if (!view.deviation.empty()) view.deviation[k] = static_cast<float>(kNoSample);
  }
}

void remove_background(const StaticBackground& background, std::vector<RangeView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) remove_background(background.masks[i], views[i]);
}

std::vector<std::string> describe(const StaticBackground& background, bool removed) {
  std::vector<std::string> lines;
  if (background.samples > 0)
    lines.push_back(
        "background: " + std::to_string(background.samples) + " samples of " +
        std::to_string(background.views) +
        " views stand still in the camera's frame while the object moves; " +
        (removed ? "they are left out (--background keep keeps them)" : "they are kept"));
  if (background.undecided > 0)
    lines.push_back("background: " + std::to_string(background.undecided) +
                    " more samples stand still, but may belong to the object; they are kept (a "
                    "mask per view leaves them out)");
  return lines;
}

}  // namespace relief
