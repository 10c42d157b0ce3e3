#include "registration/units/align_units.h"

#include "registration/units/alignment_codec_private.h"
#include "scan/base/parallel.h"
#include "scan/units/find_or_compute_private.h"
#include "scan/units/input_hash.h"

namespace relief::registration {

// A structured binding names exactly the fields there are: whoever adds one comes by here.

void hash_into(ContentHash& hash, const ViewSurfaceOptions& options) {
  const auto& [normals, normal_radius, boundary_margin, final_margin, normal_signal,
               neighbour_index] = options;
  hash.add(normals, normal_radius, boundary_margin, final_margin, normal_signal, neighbour_index);
}

void hash_into(ContentHash& hash, const StartingPoseOptions& options) {
  const auto& [given, search, association, keep_given, min_overlap, max_free_space_violation] =
      options;
  hash.add(given, search, association, keep_given, min_overlap, max_free_space_violation);
}

void hash_into(ContentHash& hash, const JointRefinementOptions& options) {
  const auto& [association, correspondences, levels, search_distance, final_samples,
               max_normal_angle_deg, min_overlap, min_correspondences, tolerance, max_iterations] =
      options;
  hash.add(association, correspondences, levels, search_distance, final_samples,
           max_normal_angle_deg, min_overlap, min_correspondences, tolerance, max_iterations);
}

void hash_into(ContentHash& hash, const AlignOptions& options) {
  const auto& [surface, starting_poses, refinement] = options;
  hash.add(surface, starting_poses, refinement);
}

void hash_into(ContentHash& hash, const CalibrationOptions& options) {
  const auto& [scope, samples] = options;
  hash.add(scope, samples);
}

static void hash_into(ContentHash& hash, const CoarseScale& scale) {
  const auto& [radius, cell] = scale;
  hash.add(radius, cell);
}

static void hash_into(ContentHash& hash, const PairSearchOptions& options) {
  const auto& [judge, seeds, candidates] = options;
  const auto& [association, probes, max_normal_angle_deg, min_stddev] = judge;
  hash.add(association, probes, max_normal_angle_deg, min_stddev, seeds, candidates);
}

static void hash_into(ContentHash& hash, const VerificationThresholds& limits) {
  const auto& [min_overlap, max_rms, max_normal_rms, max_coherent_rms, max_free_space_violation,
               max_missing_coverage] = limits;
  hash.add(min_overlap, max_rms, max_normal_rms, max_coherent_rms, max_free_space_violation,
           max_missing_coverage);
}

AlignUnits::AlignUnits(UnitStore* store, const std::vector<RangeView>& views,
                       const ViewSurfaceOptions& surface)
    : store_(store) {
  if (store_ == nullptr) return;
  surfaces_ = parallel_map<std::string>(views.size(), [&](std::size_t i) {
    return ContentHash().add(hash_of_samples(views[i]), surface).hex();
  });
}

Result<JointRefinement> AlignUnits::refine_jointly(const std::vector<ViewSurface>& surfaces,
                                                   const std::vector<RigidMotion>& world_from_view,
                                                   const std::vector<ViewRole>& roles,
                                                   const JointRefinementOptions& options,
                                                   const Progress& progress) const {
  return find_or_compute<JointRefinement>(
      store_, [&] { return unit_key("joint", surfaces_, world_from_view, roles, options); },
      [&] {
        return registration::refine_jointly(surfaces, world_from_view, roles, options, progress);
      });
}

// A part of a surface differs from it in the number of its samples.
std::string AlignUnits::key_of(const CoarseView& view, std::size_t i) const {
  return ContentHash().add(surfaces_[i], view.surface->samples().size()).hex();
}

std::vector<PoseHypothesis> AlignUnits::search_pair(const std::vector<CoarseView>& views,
                                                    std::size_t a, std::size_t b,
                                                    const CoarseScale& scale,
                                                    const PairSearchOptions& options) const {
  return find_or_compute<std::vector<PoseHypothesis>>(
             store_,
             [&] {
               return unit_key("pair", key_of(views[a], a), key_of(views[b], b), scale, options);
             },
             [&] { return Result(registration::search_pair(views[a], views[b], scale, options)); })
      .value();
}

std::vector<RigidMotion> AlignUnits::partial_symmetries(const CoarseView& view, std::size_t i,
                                                        const CoarseScale& scale,
                                                        const VerificationThresholds& limits,
                                                        const PairSearchOptions& options) const {
  return find_or_compute<std::vector<RigidMotion>>(
             store_,
             [&] {
               return unit_key("partial symmetries", key_of(view, i), scale, limits, options);
             },
             [&] { return Result(registration::partial_symmetries(view, scale, limits, options)); })
      .value();
}

}  // namespace relief::registration
