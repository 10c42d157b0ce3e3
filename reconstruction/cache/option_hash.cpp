#include "reconstruction/cache/option_hash.h"

#include "scan/units/input_hash.h"

// A structured binding names exactly the fields there are: whoever adds one comes by here.

namespace relief::registration {

void hash_into(ContentHash& hash, const DegenerateDirection& direction) {
  const auto& [motion, centre, description] = direction;
  hash.add(motion, centre, description);
}

void hash_into(ContentHash& hash, const PairFit& pair) {
  const auto& [a, b, overlap, rms, correspondences, status, normal_maps, degenerate_directions] =
      pair;
  hash.add(a, b, overlap, rms, correspondences, status, normal_maps, degenerate_directions);
}

}  // namespace relief::registration

namespace relief::hybrid {

void hash_into(ContentHash& hash, const RefineOptions& options) {
  const auto& [stencil, bias, sigma_position, sigma_normal, lambda, sigma_bias_step,
               smoothing_scale, robust_rounds, solver, tolerance, max_iterations, deviation,
               discontinuities] = options;
  hash.add(stencil, bias, sigma_position, sigma_normal, lambda, sigma_bias_step, smoothing_scale,
           robust_rounds, solver, tolerance, max_iterations, deviation, discontinuities);
}

void hash_into(ContentHash& hash, const MeshNormalOptions& options) {
  const auto& [max_distance, silhouette_ramp, sigma_view, edges] = options;
  hash.add(max_distance, silhouette_ramp, sigma_view, edges);
}

void hash_into(ContentHash& hash, const PolishOptions& options) {
  const auto& [form, sigma_position, sigma_normal, tangential, robust_rounds, tolerance,
               max_iterations, normals] = options;
  hash.add(form, sigma_position, sigma_normal, tangential, robust_rounds, tolerance, max_iterations,
           normals);
}

}  // namespace relief::hybrid

namespace relief::reconstruction {

void hash_into(ContentHash& hash, const CrossViewOptions& options) {
  const auto& [correct] = options;
  hash.add(correct);
}

}  // namespace relief::reconstruction
