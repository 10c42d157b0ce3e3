#include "relief/scan/static_background.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <utility>

#include "relief/scan/discontinuities.h"
#include "scan/background/background_mask.h"
#include "scan/background/depth_stack.h"
#include "scan/background/fixed_surface.h"
#include "scan/background/fixed_surface_evidence.h"
#include "scan/base/parallel.h"
#include "scan/grid/connected_grid.h"

namespace relief {

namespace {

constexpr std::size_t kFewestViews = 3;
constexpr std::size_t kSearched = 64;  // Views that tell what stands still; bounds memory and time.
constexpr double kLeastPart = 0.01;    // fraction of the samples: less does not stand or move
constexpr double kRefuted = 0.5;       // share of refuted samples of a background
constexpr double kConfirmed = 0.2;     // and of what the poses describe
// fraction of the pixels between both that no occlusion edge parts
constexpr double kMostAttached = 0.05;
constexpr int kSidesBeyond = 3;  // of the four sides of the image
// [tolerances of the stack]: noise that neighbours share does not show in its estimate
constexpr std::array<float, 4> kTolerances = {1.0f, 2.0f, 4.0f, 8.0f};
constexpr double kCovered = 0.99;  // fraction of the largest background

enum class Verdict { kObject, kBackground, kUndecided };

bool reaches_beyond(const PieceEvidence& piece) { return piece.sides >= kSidesBeyond; }

bool is_apart(const PieceEvidence& piece) {
  return piece.beside > 0 && piece.attached_share() <= kMostAttached;
}

// A floor turns in itself, so most of a room may be seen where the poses carry it. What is seen
// elsewhere tells, of what lies around the object: round bodies are seen in themselves as well.
Verdict judge_by_poses(const PieceEvidence& piece) {
  const double refuted = piece.poses.refuted_share();
  if (refuted >= kRefuted) return Verdict::kBackground;
  if (piece.poses.telling_refuted_share() >= kRefuted && reaches_beyond(piece) && is_apart(piece))
    return Verdict::kBackground;
  return refuted <= kConfirmed ? Verdict::kObject : Verdict::kUndecided;
}

Verdict judge(const PieceEvidence& piece, const FixedSurfaceEvidence& all) {
  if (piece.views < kFewestViews) return Verdict::kObject;
  const bool poses_describe =
      all.has_poses && all.moving_poses.enough() && all.moving_poses.refuted_share() <= kConfirmed;
  if (poses_describe && piece.poses.enough()) return judge_by_poses(piece);
  if (!reaches_beyond(piece)) return Verdict::kObject;
  return is_apart(piece) ? Verdict::kBackground : Verdict::kUndecided;
}

std::size_t count(const Grid<std::uint8_t>& mask) {
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1));
}

using Views = std::vector<const RangeView*>;

// What is found with one tolerance.
struct Attempt {
  FixedSurface surface;
  std::vector<Verdict> verdicts;
  std::size_t background = 0, undecided = 0;  // Samples on such pieces.
};

Attempt attempt(const Views& views, const DepthStack& stack, const std::vector<GridEdges>& edges) {
  Attempt result;
  result.surface = find_fixed_surface(stack);
  if (result.surface.pieces == 0) return result;
  const auto kinds = parallel_map<Grid<SampleKind>>(stack.size(), [&](std::size_t i) {
    return classify_samples(result.surface, stack.tolerance, stack.depths[i]);
  });
  const FixedSurfaceEvidence evidence = gather_evidence(views, stack, result.surface, kinds, edges);
  const double least = kLeastPart * static_cast<double>(evidence.fixed + evidence.moving);
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
Attempt best_attempt(const Views& views, DepthStack& stack, const std::vector<GridEdges>& edges) {
  const Grid<float> narrow = stack.tolerance;
  const auto widen = [&](float factor) {
    for (std::size_t i = 0; i < narrow.size(); ++i) stack.tolerance[i] = factor * narrow[i];
  };
  std::vector<std::size_t> samples;
  for (const float factor : kTolerances) {
    widen(factor);
    samples.push_back(attempt(views, stack, edges).background);
  }
  const double enough =
      kCovered * static_cast<double>(*std::max_element(samples.begin(), samples.end()));
  std::size_t k = 0;
  while (static_cast<double>(samples[k]) < enough) ++k;
  widen(kTolerances[k]);
  return attempt(views, stack, edges);
}

// The backgrounds of all cameras that some of the views were taken with.
class Backgrounds {
 public:
  explicit Backgrounds(const Views& views) {
    for (DepthStack& stack : stack_depths(views))
      if (stack.size() >= kFewestViews) search(views, stack);
  }

  bool any() const { return !cameras_.empty(); }
  std::size_t undecided() const { return undecided_; }

  // Empty where the view has none. A view of nothing but background is left to the user.
  Grid<std::uint8_t> mask(const RangeView& view) const {
    for (const CameraBackground& known : cameras_) {
      if (!same_rays(known.camera, view.camera, known.range)) continue;
      auto mask = mark_background(known, depths_of(view, known.camera), connect_samples(view));
      const std::size_t samples = count(mask);
      if (samples == 0 || samples == view.sample_count()) return {};
      return mask;
    }
    return {};
  }

 private:
  void search(const Views& views, DepthStack& stack) {
    const auto edges = parallel_map<GridEdges>(stack.size(), [&](std::size_t i) {
      return connect_samples(*views[stack.views[i]], stack.noises[i]);
    });
    Attempt best = best_attempt(views, stack, edges);
    undecided_ += best.undecided;
    if (best.background == 0) return;
    Grid<float> background = best.surface.depth;
    for (std::size_t i = 0; i < background.size(); ++i) {
      const std::int32_t piece = best.surface.piece[i];
      if (piece < 0 || best.verdicts[static_cast<std::size_t>(piece)] != Verdict::kBackground)
        background[i] = static_cast<float>(kNoSample);
    }
    cameras_.push_back({stack.camera, stack.range, std::move(stack.tolerance),
                        std::move(best.surface), std::move(background)});
  }

  std::vector<CameraBackground> cameras_;
  std::size_t undecided_ = 0;
};

// All of few views, and some evenly of many.
std::vector<std::size_t> views_to_search(std::size_t views) {
  std::vector<std::size_t> chosen(std::min(views, kSearched));
  for (std::size_t k = 0; k < chosen.size(); ++k) chosen[k] = k * views / chosen.size();
  return chosen;
}

using SharedView = std::shared_ptr<const RangeView>;

Result<std::vector<SharedView>> load_all(const std::vector<std::size_t>& numbers,
                                         const LoadRanges& load) {
  std::vector<SharedView> views;
  for (const std::size_t i : numbers) {
    auto view = load(i);
    if (!view) return view.error();
    views.push_back(std::move(*view));
  }
  return views;
}

Views pointers_to(const std::vector<SharedView>& shared) {
  Views views;
  for (const SharedView& view : shared) views.push_back(view.get());
  return views;
}

void add_mask(Grid<std::uint8_t> mask, std::size_t i, StaticBackground& found) {
  if (mask.empty()) return;
  found.samples += count(mask);
  ++found.views;
  found.masks[i] = std::move(mask);
}

}  // namespace

Result<StaticBackground> find_static_background(std::size_t views, const LoadRanges& load) {
  StaticBackground found;
  found.masks.resize(views);
  if (views < kFewestViews) return found;
  std::vector<std::size_t> numbers = views_to_search(views);
  auto held = load_all(numbers, load);
  if (!held) return held.error();
  const Backgrounds backgrounds(pointers_to(*held));
  found.undecided = backgrounds.undecided();
  if (!backgrounds.any()) return found;
  for (std::size_t begin = 0; begin < views; begin += kSearched) {
    numbers.resize(std::min(kSearched, views - begin));
    std::iota(numbers.begin(), numbers.end(), begin);
    held->clear();
    held = load_all(numbers, load);
    if (!held) return held.error();
    auto masks = parallel_map<Grid<std::uint8_t>>(
        held->size(), [&](std::size_t k) { return backgrounds.mask(*(*held)[k]); });
    for (std::size_t k = 0; k < masks.size(); ++k) add_mask(std::move(masks[k]), begin + k, found);
  }
  return found;
}

StaticBackground find_static_background(const std::vector<RangeView>& views) {
  // Pointers that own nothing. Nothing is read, so there are no errors.
  const auto load = [&](std::size_t i) -> Result<SharedView> {
    return SharedView(std::shared_ptr<void>(), &views[i]);
  };
  return find_static_background(views.size(), load).value();
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
