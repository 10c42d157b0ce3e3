#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "scan/io/clouds/cloud_rays.h"
#include "scan/io/clouds/files/point_cloud_file.h"

namespace relief {

/// The least depth of each cell of a plane, by hashing.
class DepthCells {
 public:
  explicit DepthCells(std::size_t points) {
    while (capacity_ < 2 * points) capacity_ *= 2;
  }

  void clear() {
    keys_.assign(capacity_, kNone);
    depths_.resize(capacity_);
    used_ = 0;
  }

  double& depth(std::int32_t u, std::int32_t v, double initial) {
    const std::uint64_t key =
        std::uint64_t{static_cast<std::uint32_t>(u)} << 32 | static_cast<std::uint32_t>(v);
    std::size_t slot = (key * 0x9E3779B97F4A7C15ull >> 20) & (capacity_ - 1);
    while (keys_[slot] != kNone && keys_[slot] != key) slot = (slot + 1) & (capacity_ - 1);
    if (keys_[slot] == kNone) {
      keys_[slot] = key;
      depths_[slot] = initial;
      ++used_;
    }
    return depths_[slot];
  }

  std::size_t used() const { return used_; }

 private:
  static constexpr std::uint64_t kNone = 0x8000000080000000ull;  // No cell lies there.
  std::size_t capacity_ = 16, used_ = 0;
  std::vector<std::uint64_t> keys_;
  std::vector<double> depths_;
};

struct DirectionScore {
  double hidden = 0.0;  ///< Fraction of the points, that others hide or whose normals are averted.
  std::size_t cells = 0;  ///< The area of the picture.
};

/// Of the points that share a cell with a nearer one, those that lie behind a gap in depth.
struct GapScore {
  double behind = 0.0;          ///< Fraction of them.
  double standard_error = 1.0;  ///< Of the fraction, by the count of points; 1: there are none.
};

/// Judges rays by an even choice of the points of a cloud.
class DirectionJudge {
 public:
  static constexpr double kCell = 1.0;  ///< The side of a cell [spacings], if not another is set.

  explicit DirectionJudge(const PointCloudFile& cloud);

  DirectionScore score(const CloudRays& rays);
  /// Of parallel rays.
  DirectionScore score(const Eigen::Vector3d& direction) {
    return score(parallel_rays(direction, centre_));
  }

  /// How many of the points that share a line of sight lie behind a gap, in cells of one spacing.
  /// Surfaces at grazing angles are deep in a cell, but have no gaps; those behind others have.
  /// Unlike hidden points, the fraction does not depend on how densely rays are sampled.
  GapScore score_gaps(const CloudRays& rays) const;

  /// The side of a cell [spacings].
  void set_cell(double cell) { cell_ = cell; }

  bool has_normals() const { return !normals_.empty(); }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  const Eigen::Vector3d& centre() const { return centre_; }

 private:
  bool averted(std::size_t i, const CloudRays& rays) const;

  double cell_ = kCell;              // [spacings]
  std::vector<std::size_t> chosen_;  // Of the cloud's points.
  std::vector<Eigen::Vector3d> points_, normals_, projected_;
  DepthCells cells_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double spacing_ = 0.0, extent_ = 0.0;
};

}  // namespace relief
