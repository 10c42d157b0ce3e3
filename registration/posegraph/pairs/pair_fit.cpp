#include "registration/posegraph/pairs/pair_fit.h"

#include <algorithm>
#include <cmath>

#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"

namespace relief::registration {

namespace {

// Pairs that share fewer samples or less of the views than this are thin. Only their status in
// reports depends on it. 200 samples tell an RMS to 5 % (1 / sqrt(2 n)).
constexpr double kThinSamples = 200.0;
constexpr double kThinOverlap = 0.1;  // Fraction; 2.5 times what a pair must share to be used.

// In the order of what matters most about a pair.
PairStatus grade_of(const PairFit& fit, double shared_samples, double largest_rms) {
  if (fit.rms > largest_rms) return PairStatus::kMisfit;
  if (fit.overlap < kThinOverlap || shared_samples < kThinSamples) return PairStatus::kThin;
  return fit.degenerate_directions.empty() ? PairStatus::kDetermined : PairStatus::kDegenerate;
}

}  // namespace

double degeneracy_threshold(const ViewSurface& a, const ViewSurface& b) {
  return eigenvalue_threshold(std::max(a.normal_noise(), b.normal_noise()));
}

PairFit fit_of(const std::vector<ViewSurface>& surfaces,
               const std::vector<RigidMotion>& world_from_view, const SharedSurface& shared,
               const DirectedMatches& forward, const DirectedMatches& backward) {
  PairFit fit;
  fit.a = forward.source;
  fit.b = forward.target;
  fit.overlap = 0.5 * (forward.found.overlap() + backward.found.overlap());
  NormalMatches normals;
  double squares = 0.0;
  for (const auto* directed : {&forward, &backward}) {
    const RigidMotion& pose = world_from_view[directed->target];
    for (const auto& c : directed->found.items) squares += c.distance * c.distance;
    for (const auto& match : directed->normals.items) normals.items.push_back(match.moved(pose));
    normals.effective_sigma = std::max(normals.effective_sigma, directed->normals.effective_sigma);
    normals.redundancy = std::max(normals.redundancy, directed->normals.redundancy);
  }
  fit.correspondences = shared.points.size();
  if (!shared.points.empty())
    fit.rms = std::sqrt(squares / static_cast<double>(shared.points.size()));
  const double threshold = degeneracy_threshold(surfaces[fit.a], surfaces[fit.b]);
  const SharedConstraints held = shared_constraints(shared.points, shared.normals);
  ConstraintSpectrum spectrum = held.spectrum;
  // Below the threshold is what noise explains, however little of it both views share.
  for (Eigen::Index k = 0; k < 6; ++k)
    if (held.correlations[k] < kNoSharedRelief)
      spectrum.eigenvalues[k] = std::min(spectrum.eigenvalues[k], 0.5 * threshold);
  spectrum = sorted(spectrum);
  if (!normals.items.empty())
    spectrum = with_normal_maps(
        spectrum, normals,
        std::max(forward.found.sigma, backward.found.sigma) / normals.effective_sigma, threshold);
  fit.normal_maps = !normals.items.empty();
  fit.degenerate_directions = degenerate_directions(spectrum, threshold);
  return fit;
}

void set_pair_statuses(const std::vector<ViewSurface>& surfaces, std::vector<PairFit>& pairs) {
  const auto limits = largest_fitting_rms(surfaces, pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    PairFit& fit = pairs[i];
    const std::size_t samples =
        std::min(surfaces[fit.a].samples().size(), surfaces[fit.b].samples().size());
    fit.status = grade_of(fit, fit.overlap * static_cast<double>(samples), limits[i]);
  }
}

std::vector<double> largest_fitting_rms(const std::vector<ViewSurface>& surfaces,
                                        const std::vector<PairFit>& pairs) {
  std::vector<double> all, limits;
  for (const auto& pair : pairs) all.push_back(pair.rms);
  const double common = kUncommon * quantile(all, 0.5);
  for (const auto& pair : pairs) {
    const ViewSurface &a = surfaces[pair.a], &b = surfaces[pair.b];
    limits.push_back(
        std::max(common, largest_plausible_rms(coarser_spacing(a, b), joint_noise(a, b))));
  }
  return limits;
}

std::string_view to_string(PairStatus status) {
  switch (status) {
    case PairStatus::kDetermined:
      return "firm";
    case PairStatus::kDegenerate:
      return "degenerate";
    case PairStatus::kThin:
      return "thin";
    case PairStatus::kMisfit:
      return "misfit";
  }
  return "unknown";
}

}  // namespace relief::registration
