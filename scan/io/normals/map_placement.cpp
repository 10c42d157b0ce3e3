#include "scan/io/normals/map_placement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <vector>

#include "scan/base/median.h"
#include "scan/io/normals/normal_evidence.h"

namespace relief {

namespace {

constexpr int kSearchedSteps = 16;          // To each side, of half a window. Bound the time.
constexpr std::size_t kMostSearched = 500;  // Patches that are looked at in the search, the same.
// Differences between neighbouring windows where the map lies, by those where it was stored, and by
// those of the depth alone: 0.2 to 0.35 for maps of the simulated object that are mirrored or moved
// by 8 pixels, 0.5 for 4 pixels; 0.9 and more for right ones anywhere else.
constexpr double kFarLess = 0.5;
// Pairs of neighbouring windows. The best of many places halves the differences of fewer by chance.
constexpr std::size_t kFewestPairs = 64;

// Mean directions of the windows round all pixels, as those of patches are; NaN where less than
// half of the window has a direction, or they disagree.
Grid<Eigen::Vector3f> window_means(const Grid<Eigen::Vector3f>& stored, int radius) {
  constexpr float kCoherent = 0.7f;  // Mean length of directions: cos 45 deg of their cone.
  const int width = stored.width(), height = stored.height();
  Grid<Eigen::Vector4d> sums(width + 1, height + 1, Eigen::Vector4d::Zero());
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      Eigen::Vector4d one = Eigen::Vector4d::Zero();
      if (is_direction(stored(u, v).cast<double>()))
        one << stored(u, v).cast<double>().normalized(), 1.0;
      sums(u + 1, v + 1) = one + sums(u, v + 1) + sums(u + 1, v) - sums(u, v);
    }
  }
  Grid<Eigen::Vector3f> means(width, height,
                              Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  const double whole = (2.0 * radius + 1.0) * (2.0 * radius + 1.0);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int left = std::max(0, u - radius), right = std::min(width, u + radius + 1);
      const int top = std::max(0, v - radius), bottom = std::min(height, v + radius + 1);
      const Eigen::Vector4d sum =
          sums(right, bottom) - sums(left, bottom) - sums(right, top) + sums(left, top);
      const double length = sum.head<3>().norm();
      if (2.0 * sum[3] >= whole && length >= kCoherent * sum[3])
        means(u, v) = (sum.head<3>() / length).cast<float>();
    }
  }
  return means;
}

// Where the pixel of the map lies that falls on pixel (u, v) of the depth.
struct MapPlace {
  MapPlacement by;
  int width, height;

  int column(int u) const { return by.mirrored_across ? width - 1 - (u - by.right) : u - by.right; }
  int row(int v) const { return by.mirrored_down ? height - 1 - (v - by.down) : v - by.down; }
};

// The patches of a view with their pixels, and a map that can be laid on them anywhere.
class PlacedMap {
 public:
  PlacedMap(const NormalEvidence& evidence, const Grid<Eigen::Vector3f>& stored)
      : evidence_(evidence), means_(window_means(stored, evidence.patches.radius)) {
    const NormalPatches& patches = evidence.patches;
    for (int row = 0; row < patches.lattice.height(); ++row)
      for (int column = 0; column < patches.lattice.width(); ++column)
        if (const int index = patches.lattice(column, row); index >= 0)
          pixels_.push_back({column * patches.step + patches.step / 2,
                             row * patches.step + patches.step / 2, index});
    for (const NormalConvention& convention : all_conventions(evidence.kind))
      if (evidence.possible(convention)) to_view_.push_back(evidence.view_from_stored(convention));
  }

  /// The mean cosine of the angles between patches and the map at a place, in the convention that
  /// is best there. Minus infinity where more than half of the patches miss the map.
  double agreement_at(const MapPlacement& by, Eigen::Matrix3d& best_to_view) const {
    const MapPlace place{by, means_.width(), means_.height()};
    const std::size_t step = 1 + pixels_.size() / kMostSearched;
    // The cosines of all conventions are in it.
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    double count = 0.0;
    for (std::size_t k = 0; k < pixels_.size(); k += step) {
      const Eigen::Vector3d direction = mean_at(place, pixels_[k]);
      if (!direction.allFinite()) continue;
      products += direction * surface(pixels_[k]).transpose();
      count += 1.0;
    }
    double best = -std::numeric_limits<double>::infinity();
    if (2.0 * count * static_cast<double>(step) < static_cast<double>(pixels_.size())) return best;
    for (const Eigen::Matrix3d& to_view : to_view_) {
      const double cosine = (to_view * products).trace() / count;
      if (!(cosine > best)) continue;
      best = cosine;
      best_to_view = to_view;
    }
    return best;
  }

  /// Medians over patches, and over pairs of neighbours.
  struct Errors {
    double angle = 0.0;   ///< [rad]
    double relief = 0.0;  ///< Of the difference between neighbours.
    double plane = 0.0;   ///< The same of the depth alone.
    std::size_t pairs = 0;
  };
  Errors errors_at(const MapPlacement& by, const Eigen::Matrix3d& to_view) const {
    const MapPlace place{by, means_.width(), means_.height()};
    const Grid<int>& lattice = evidence_.patches.lattice;
    std::vector<Eigen::Vector3d> placed(evidence_.patches.patches.size());
    std::vector<double> angles, reliefs, planes;
    for (const Pixel& pixel : pixels_) {
      const Eigen::Vector3d direction = to_view * mean_at(place, pixel);
      placed[static_cast<std::size_t>(pixel.patch)] = direction;
      if (direction.allFinite())
        angles.push_back(std::acos(std::clamp(direction.dot(surface(pixel)), -1.0, 1.0)));
    }
    for_each_pair(lattice, [&](std::size_t a, std::size_t b) {
      if (!placed[a].allFinite() || !placed[b].allFinite()) return;
      const auto& patches = evidence_.patches.patches;
      const Eigen::Vector3d step = patches[b].surface - patches[a].surface;
      reliefs.push_back((step - (placed[b] - placed[a])).norm());
      planes.push_back(step.norm());
    });
    const std::size_t pairs = reliefs.size();
    return {median(std::move(angles)), median(std::move(reliefs)), median(std::move(planes)),
            pairs};
  }

 private:
  struct Pixel {
    int u, v, patch;
  };

  const Eigen::Vector3d& surface(const Pixel& pixel) const {
    return evidence_.patches.patches[static_cast<std::size_t>(pixel.patch)].surface;
  }

  Eigen::Vector3d mean_at(const MapPlace& place, const Pixel& pixel) const {
    const int u = place.column(pixel.u), v = place.row(pixel.v);
    if (means_.contains(u, v)) return means_(u, v).cast<double>();
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }

  template <typename Body>
  static void for_each_pair(const Grid<int>& lattice, const Body& body) {
    for (int row = 0; row < lattice.height(); ++row)
      for (int column = 0; column < lattice.width(); ++column)
        for (const auto& [right, down] : {std::pair{1, 0}, {0, 1}})
          if (lattice(column, row) >= 0 && lattice.contains(column + right, row + down) &&
              lattice(column + right, row + down) >= 0)
            body(static_cast<std::size_t>(lattice(column, row)),
                 static_cast<std::size_t>(lattice(column + right, row + down)));
  }

  const NormalEvidence& evidence_;
  Grid<Eigen::Vector3f> means_;
  std::vector<Pixel> pixels_;
  std::vector<Eigen::Matrix3d> to_view_;  // By the conventions that are possible.
};

// The best place of a search.
struct FoundPlace {
  MapPlacement by;
  Eigen::Matrix3d to_view = Eigen::Matrix3d::Identity();
  double agreement = -std::numeric_limits<double>::infinity();
};

// Looks at places round that of `found`, `stride` pixels apart, and takes the best.
void search_round(const PlacedMap& map, int steps, int stride, FoundPlace& found) {
  const MapPlacement middle = found.by;
  for (int down = -steps; down <= steps; ++down) {
    for (int right = -steps; right <= steps; ++right) {
      FoundPlace other{middle};
      other.by.right += right * stride;
      other.by.down += down * stride;
      other.agreement = map.agreement_at(other.by, other.to_view);
      if (other.agreement > found.agreement) found = other;
    }
  }
}

// The best places of the map as it is, mirrored, and turned.
std::vector<FoundPlace> search(const PlacedMap& map, int stride) {
  std::vector<FoundPlace> places;
  for (const bool across : {false, true}) {
    for (const bool down : {false, true}) {
      FoundPlace& found = places.emplace_back();
      found.by.mirrored_across = across;
      found.by.mirrored_down = down;
      search_round(map, kSearchedSteps, stride, found);
      search_round(map, stride, 1, found);
    }
  }
  return places;
}

std::string mirror_text(const MapPlacement& placement) {
  if (placement.mirrored_across && placement.mirrored_down) return "turned by 180 deg";
  if (placement.mirrored_across) return "mirrored left to right";
  return placement.mirrored_down ? "mirrored top to bottom" : "";
}

// `4 pixels to the right`; nothing for 0.
std::string move_text(int pixels, const char* forth, const char* back) {
  if (pixels == 0) return "";
  return std::to_string(std::abs(pixels)) + (std::abs(pixels) == 1 ? " pixel " : " pixels ") +
         (pixels > 0 ? forth : back);
}

std::string joined(const std::string& a, const std::string& b) {
  return a + (a.empty() || b.empty() ? "" : " and ") + b;
}

}  // namespace

std::string to_string(const MapPlacement& placement) {
  const std::string move = joined(move_text(placement.right, "to the right", "to the left"),
                                  move_text(placement.down, "down", "up"));
  return joined(mirror_text(placement), move.empty() ? "" : "moved by " + move);
}

std::optional<MapPlacement> find_placement(const NormalEvidence& evidence,
                                           const Grid<Eigen::Vector3f>& stored) {
  if (evidence.patches.patches.size() < kFewestPairs / 2) return std::nullopt;
  const PlacedMap map(evidence, stored);
  FoundPlace as_stored;
  search_round(map, 0, 1, as_stored);
  const auto here = map.errors_at(as_stored.by, as_stored.to_view);
  std::optional<MapPlacement> best;
  double least = kFarLess;
  for (const FoundPlace& place : search(map, std::max(1, evidence.patches.radius))) {
    const auto there = map.errors_at(place.by, place.to_view);
    const double ratio = there.relief / std::min(here.relief, there.plane);
    if (there.pairs < kFewestPairs || !(there.angle < here.angle) || !(ratio < least)) continue;
    least = ratio;
    best = place.by;
    best->median = there.angle;
  }
  return best;
}

}  // namespace relief
