#include "scan/background/background_mask.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "scan/base/disjoint_sets.h"
#include "scan/base/linear_algebra.h"

namespace relief {

namespace {

constexpr std::size_t kLargestSpeck = 9;  // samples that noise alone cuts off
constexpr double kReach = 3.0;            // from the background, of what belongs to it [tolerances]
constexpr double kPlane = 1.0;            // RMS error of a background that is a plane [tolerances]
constexpr double kOnPlane = 0.9;          // fraction of the samples of a gap
constexpr int kMargin = 8;                // round a gap [pixels], doubled until
constexpr std::size_t kFewestPoints = 200;  // are in it

struct Pixel {
  int u, v;
};

class ViewMask {
 public:
  ViewMask(const CameraBackground& known, const Grid<float>& depth, const GridEdges& edges)
      : known_(known),
        depth_(depth),
        kinds_(classify_samples(known.surface, known.tolerance, depth)),
        background_(known.background),
        edges_(edges),
        mask_(depth.width(), depth.height(), 0) {
    for (std::size_t i = 0; i < kinds_.size(); ++i)
      mask_[i] = kinds_[i] == SampleKind::kStanding && is_near(i, 1.0);
    add_unknown();
    add_specks();
  }

  Grid<std::uint8_t> take() { return std::move(mask_); }

 private:
  // Calls `body(a, b)` for the indices of samples that are neighbours on one surface.
  template <typename Body>
  void for_each_edge(const Body& body) const {
    const auto at = [&](int u, int v) { return static_cast<std::uint32_t>(mask_.index(u, v)); };
    for (int v = 0; v < mask_.height(); ++v) {
      for (int u = 0; u < mask_.width(); ++u) {
        if (edges_.right(u, v)) body(at(u, v), at(u + 1, v));
        if (edges_.down(u, v)) body(at(u, v), at(u, v + 1));
      }
    }
  }

  bool is_near(std::size_t i, double tolerances) const {
    return std::abs(depth_[i] - background_[i]) <= tolerances * known_.tolerance[i];
  }

  // Components of samples of which few views know more: by what they are attached to, else by
  // where they lie. The background shows through gaps of the object that few views look through.
  void add_unknown() {
    const auto unknown = [&](std::size_t i) { return kinds_[i] == SampleKind::kUnknown; };
    DisjointSets sets(mask_.size());
    for_each_edge([&](std::uint32_t a, std::uint32_t b) {
      if (unknown(a) && unknown(b)) sets.join(a, b);
    });
    std::vector<std::uint32_t> to_background(mask_.size(), 0), to_others(mask_.size(), 0);
    for_each_edge([&](std::uint32_t a, std::uint32_t b) {
      if (unknown(a) == unknown(b)) return;
      const std::uint32_t inside = unknown(a) ? a : b, outside = unknown(a) ? b : a;
      ++(mask_[outside] ? to_background : to_others)[sets.find(inside)];
    });
    std::map<std::uint32_t, std::vector<Pixel>> gaps;
    for (int v = 0; v < mask_.height(); ++v) {
      for (int u = 0; u < mask_.width(); ++u) {
        const auto i = static_cast<std::uint32_t>(mask_.index(u, v));
        if (!unknown(i)) continue;
        const std::uint32_t set = sets.find(i);
        if (to_background[set] > to_others[set])
          mask_[i] = 1;
        else if (to_others[set] == 0)
          gaps[set].push_back({u, v});
      }
    }
    for (const auto& [set, pixels] : gaps)
      if (continues_plane(pixels))
        for (const Pixel& pixel : pixels) mask_(pixel.u, pixel.v) = 1;
  }

  // Whether nearly all samples lie on the plane through the background round about, which must be
  // one.
  bool continues_plane(const std::vector<Pixel>& pixels) const {
    int u0 = mask_.width(), u1 = 0, v0 = mask_.height(), v1 = 0;
    for (const Pixel& pixel : pixels) {
      u0 = std::min(u0, pixel.u), u1 = std::max(u1, pixel.u);
      v0 = std::min(v0, pixel.v), v1 = std::max(v1, pixel.v);
    }
    const int longest = std::max(mask_.width(), mask_.height());
    for (int margin = kMargin; margin < longest; margin *= 2) {
      const PlaneFit plane = fit_plane(u0 - margin, u1 + margin, v0 - margin, v1 + margin);
      if (plane.points < kFewestPoints) continue;
      if (plane.error > kPlane) return false;
      std::size_t on_plane = 0;
      for (const Pixel& pixel : pixels) {
        const double off = plane.depth(known_.camera.ray(pixel.u, pixel.v)) -
                           static_cast<double>(depth_(pixel.u, pixel.v));
        on_plane += std::abs(off) <= kReach * known_.tolerance(pixel.u, pixel.v) ? 1 : 0;
      }
      return static_cast<double>(on_plane) >= kOnPlane * static_cast<double>(pixels.size());
    }
    return false;
  }

  struct PlaneFit {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    std::size_t points = 0;
    double error = 0.0;  // RMS distance of the background from it [tolerances].

    double depth(const Ray& ray) const {
      return (mean - ray.origin).dot(normal) / ray.direction.dot(normal) * ray.direction.norm();
    }
  };

  PlaneFit fit_plane(int u0, int u1, int v0, int v1) const {
    std::vector<Eigen::Vector3d> points;
    double tolerance = 0.0;
    PlaneFit fit;
    for (int v = std::max(0, v0); v <= std::min(v1, mask_.height() - 1); ++v) {
      for (int u = std::max(0, u0); u <= std::min(u1, mask_.width() - 1); ++u) {
        if (!std::isfinite(background_(u, v))) continue;
        const Ray ray = known_.camera.ray(u, v);
        points.push_back(ray.at(background_(u, v) / ray.direction.norm()));
        tolerance += known_.tolerance(u, v);
        fit.mean += points.back();
      }
    }
    fit.points = points.size();
    if (fit.points < kFewestPoints) return fit;
    const double count = static_cast<double>(fit.points);
    fit.mean /= count;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& point : points) scatter += (point - fit.mean) * (point - fit.mean).transpose();
    const auto eigen = eigen_decomposition(scatter);
    fit.normal = eigen.eigenvectors().col(0);
    fit.error = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / count) / (tolerance / count);
    return fit;
  }

  // Small components of what is left that the background surrounds, and that are close to it: the
  // rim of the object may be cut off from it, too.
  void add_specks() {
    const auto left = [&](std::size_t i) { return kinds_[i] != SampleKind::kNone && !mask_[i]; };
    DisjointSets sets(mask_.size());
    for_each_edge([&](std::uint32_t a, std::uint32_t b) {
      if (left(a) && left(b)) sets.join(a, b);
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
      speck_[i] =
          is_near(i, kReach) && sizes[set] <= kLargestSpeck && 2 * beside[set] > around[set];
    }
    for (std::uint32_t i = 0; i < mask_.size(); ++i)
      if (speck_[i]) mask_[i] = 1;
  }

  const CameraBackground& known_;
  const Grid<float>& depth_;
  const Grid<SampleKind> kinds_;
  const Grid<float>& background_;
  const GridEdges& edges_;
  Grid<std::uint8_t> mask_;
  std::vector<bool> speck_ = std::vector<bool>(mask_.size(), false);
};

}  // namespace

Grid<std::uint8_t> mark_background(const CameraBackground& known, const Grid<float>& depths,
                                   const GridEdges& edges) {
  return ViewMask(known, depths, edges).take();
}

}  // namespace relief
