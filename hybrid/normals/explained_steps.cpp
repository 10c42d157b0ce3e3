#include "hybrid/normals/explained_steps.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "hybrid/model/range_steps.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Standard deviations; 0.3 % of a Gaussian lies beyond. At half of it a seventh of the edges at a
// rim stay cut, at twice a surface joins another that lies 8.5 deviations behind.
constexpr double kDeviations = 3.0;
// Cosine of incidence below which a normal explains any step: sin(8 deg), the default of
// DiscontinuityOptions::grazing_angle_deg.
constexpr double kEdgeOn = 0.14;

bool explained(const RangeView& view, int u, int v, int du, int dv, double sigma) {
  if (!view.has_sample(u, v) || !view.has_sample(u + du, v + dv)) return false;
  const std::optional<RangeStep> step = range_step(view, u, v, du, dv);
  if (!step || !(step->incidence > kEdgeOn)) return false;
  return std::abs(step->discrepancy) <= kDeviations * std::numbers::sqrt2 * sigma;
}

}  // namespace

void connect_explained_steps(const RangeView& view, double sigma, GridEdges& edges) {
  if (!view.has_normals()) return;
  parallel_rows(view.height(), [&](int v) {
    for (int u = 0; u < view.width(); ++u) {
      if (u + 1 < view.width() && !edges.right(u, v) && explained(view, u, v, 1, 0, sigma))
        edges.right(u, v) = 1;
      if (v + 1 < view.height() && !edges.down(u, v) && explained(view, u, v, 0, 1, sigma))
        edges.down(u, v) = 1;
    }
  });
}

}  // namespace relief::hybrid
