#pragma once

#include <cstddef>
#include <vector>

#include "relief/scan/range_view.h"
#include "scan/background/depth_stack.h"
#include "scan/background/fixed_surface.h"

namespace relief {

/// Whether the poses of the views let a set of samples be part of what they see: a sample carried
/// into another view is refuted where that view sees through it by far.
struct CarriedSamples {
  std::size_t confirmed = 0, refuted = 0;
  std::size_t in_itself = 0;  ///< Of those confirmed: seen on the fixed surface.
  bool enough() const;
  double refuted_share() const;
  /// The share of those that tell: samples seen on the fixed surface would be so anyway. 0 where
  /// they are too few against noise.
  double telling_refuted_share() const;
};

/// What speaks for and against a piece of the standing surface being background.
struct PieceEvidence {
  std::size_t samples = 0;   ///< In all views.
  std::size_t views = 0;     ///< That see it.
  std::size_t beside = 0;    ///< Pairs of neighbouring pixels, one on it and one that moves,
  std::size_t attached = 0;  ///< and how many of these are on one continuous surface.
  int sides = 0;             ///< Of the image of what moves beyond which it reaches, 0 to 4.
  CarriedSamples poses;
  double attached_share() const;
};

struct FixedSurfaceEvidence {
  std::vector<PieceEvidence> pieces;
  std::size_t fixed = 0, moving = 0;  ///< Samples in all views.
  bool has_poses = false;             ///< All views have one.
  CarriedSamples moving_poses;        ///< Of what moves: whether the poses describe its motion.
};

/// `edges` are those of each view of the stack.
FixedSurfaceEvidence gather_evidence(const std::vector<const RangeView*>& views,
                                     const DepthStack& stack, const FixedSurface& surface,
                                     const std::vector<Grid<SampleKind>>& kinds,
                                     const std::vector<GridEdges>& edges);

}  // namespace relief
