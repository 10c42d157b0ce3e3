#pragma once

#include <cstddef>
#include <vector>

#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"

namespace relief::registration {

/// One loop may close by chance (docs/results.md, Global registration).
inline constexpr int kTellingLoops = 2;

/// For each link how many views c confirm it by two others: a - c - b leads to the same pose. Views
/// that links lay on each other, as if they were seen from one place to 0.2 radii, may be held
/// there by what stands still before the sensor, or by the outline within which it sees a body of
/// revolution: loops of three such links always close, and confirm nothing. Nor does a view that
/// was taken again from the place of another one: both fit at the same wrong poses.
std::vector<int> count_loops(const std::vector<ViewSurface>& surfaces,
                             const std::vector<PoseLink>& links);

/// What links must show, in terms of the errors that these views have.
struct LinkLimits {
  VerificationThresholds lone;       ///< Links that no loop confirms.
  VerificationThresholds confirmed;  ///< Links that loops confirm, and pairs at poses of chains.
  /// Links that kTellingLoops loops or more confirm, and the pairs of these. Strays depend on the
  /// pair, and samples are few: such poses may show as many as those that `confirmed` follows from.
  /// Noise depends on the pair too: they may deviate by as much as nine tenths of such links do.
  VerificationThresholds loop_confirmed;
};

/// Whether a pose may be right although it deviates by more than `general` allows: smooth errors of
/// a calibration move surfaces apart, but hardly turn their normals nor stand in space seen empty.
bool may_be_right(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                  const VerificationThresholds& general);

/// Limits for links that samples off the flat faces confirm: these tell wrong poses from right ones
/// that errors of the sensor bend, so the coherent RMS may be that of may_be_right().
VerificationThresholds widened_coherent_limit(VerificationThresholds limits,
                                              const VerificationThresholds& general);

/// common_stddev() of the pairs of views whose links close loops, each by its first one that does;
/// links of a pair follow each other. 0 where these are fewer than four, and where errors are more
/// than half a percent of the views' radius: wrong poses of small things misfit by as little.
double stddev_of_loops(const std::vector<ViewSurface>& surfaces,
                       const std::vector<PoseLink>& links);

/// Fits the limits to the links of a project. Errors of a sensor are in all of its pairs: links
/// that close loops with each other show how large they are, and the limits follow. A link that
/// deviates much more than the better ones is wrong. `loops`: of count_loops().
LinkLimits fit_link_limits(const std::vector<ViewSurface>& surfaces,
                           const std::vector<PoseLink>& links, const std::vector<int>& loops,
                           const ViewGroupOptions& options);

}  // namespace relief::registration
