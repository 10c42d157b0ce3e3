#pragma once

#include "registration/units/alignment_codec_private.h"
#include "relief/fusion/merge_views.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/cross_view_consistency.h"
#include "relief/scan/mesh_check.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/units/unit_codec_private.h"

// How cereal writes the results of the stages. A structured binding names exactly the fields there
// are; structs with a base take it first.

namespace relief {

template <class Archive>
void serialize(Archive& archive, TriangleMesh& mesh) {
  auto& [vertices, faces, normals, quality, views, source_views, filled, colours] = mesh;
  archive(vertices, faces, normals, quality, views, source_views, filled, colours);
}

template <class Archive>
void serialize(Archive& archive, SelfIntersections& found) {
  auto& [pairs, complete] = found;
  archive(pairs, complete);
}

template <class Archive>
void serialize(Archive& archive, MeshCheck& check) {
  auto& [vertices, faces, edges, boundary_edges, non_manifold_edges, inconsistent_edges,
         non_manifold_vertices, unused_vertices, degenerate_faces, duplicate_vertices,
         invalid_faces, non_finite_vertices, components, genus, volume, self_intersections] = check;
  archive(vertices, faces, edges, boundary_edges, non_manifold_edges, inconsistent_edges,
          non_manifold_vertices, unused_vertices, degenerate_faces, duplicate_vertices,
          invalid_faces, non_finite_vertices, components, genus, volume, self_intersections);
}

}  // namespace relief

namespace relief::hybrid {

template <class Archive>
void serialize(Archive& archive, DeviationBand& band) {
  auto& [wavelength, measured, refined] = band;
  archive(wavelength, measured, refined);
}

template <class Archive>
void serialize(Archive& archive, RefineSummary& summary) {
  auto& [status, sigma_position, sigma_normal, lambda, bias_rms, rms_change, refined, kept, flying,
         filled, replaced_normals, outlier_normals, rounds, iterations, seconds, spectrum] =
      summary;
  archive(status, sigma_position, sigma_normal, lambda, bias_rms, rms_change, refined, kept, flying,
          filled, replaced_normals, outlier_normals, rounds, iterations, seconds, spectrum);
}

template <class Archive>
void serialize(Archive& archive, PolishSummary& summary) {
  auto& [status, with_normal, sigma_view, rms_move, max_move, damped, unmoved, rounds, iterations,
         seconds] = summary;
  archive(status, with_normal, sigma_view, rms_move, max_move, damped, unmoved, rounds, iterations,
          seconds);
}

template <class Archive>
void serialize(Archive& archive, PolishedMesh& polished) {
  archive(static_cast<PolishSummary&>(polished), polished.mesh);
}

}  // namespace relief::hybrid

namespace relief::fusion {

template <class Archive>
void serialize(Archive& archive, MergeSummary& summary) {
  auto& [filled_area_fraction, voxel_size, truncation, view_noise, inter_view_stddev,
         range_exponent, flying_samples, filled_samples, noisy_samples, contradicted_views,
         moving_blocks, small_handles, handles_removed, components_removed, faces_removed, notes] =
      summary;
  archive(filled_area_fraction, voxel_size, truncation, view_noise, inter_view_stddev,
          range_exponent, flying_samples, filled_samples, noisy_samples, contradicted_views,
          moving_blocks, small_handles, handles_removed, components_removed, faces_removed, notes);
}

template <class Archive>
void serialize(Archive& archive, MergeResult& merged) {
  archive(static_cast<MergeSummary&>(merged), merged.mesh, merged.check);
}

}  // namespace relief::fusion

namespace relief::reconstruction {

template <class Archive>
void serialize(Archive& archive, ViewConsistency& view) {
  auto& [compared, contradicted, corrected, deviation] = view;
  archive(compared, contradicted, corrected, deviation);
}

}  // namespace relief::reconstruction
