#include "relief/fusion/merge_views.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

#include "fusion/holes/fair_holes.h"
#include "fusion/holes/filled_regions.h"
#include "fusion/mesh/crease_edges.h"
#include "fusion/mesh/measured_components.h"
#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "fusion/surface/vertex_colours.h"
#include "fusion/tsdf/closed_field.h"
#include "fusion/units/merge_units.h"
#include "fusion/views/inter_view_errors.h"
#include "fusion/views/prepared_samplers.h"
#include "scan/base/median.h"
#include "scan/base/median_deviation.h"
#include "scan/base/parallel.h"
#include "scan/units/content_hash.h"
#include "scan/units/input_hash.h"

namespace relief::fusion {

namespace {

// How far merging is when views are prepared, when there is a field, a mesh, a mesh along creases,
// and when that is measured: parts of the time, on the twelve refined views of the demo.
constexpr double kPrepared = 0.08, kField = 0.65, kMesh = 0.75, kSurface = 0.94, kMeasured = 0.97;

// Progress of a part, which is from `begin` to `end` of the whole.
Progress part_of(const Progress& whole, double begin, double end) {
  return [&whole, begin, end](double fraction, std::string_view step) {
    return report_progress(whole, begin + fraction * (end - begin), step);
  };
}

struct SampleQuality {
  double deviation = 0.0;  // Median of the views' median deviations; 0: no view has any.
  bool refined = false;    // Any view is.
};

struct Inputs {
  SampleQuality quality;
  std::size_t samples = 0;          // Of all views.
  std::vector<std::string> hashes;  // Of the views, where units are kept.
};

Result<Inputs> look_at(const ViewSource& views, bool hashed, MemoryLimit* memory) {
  Inputs inputs;
  SampleQuality& quality = inputs.quality;
  std::vector<double> medians;
  for (std::size_t i = 0; i < views.count; ++i) {
    const auto view = views.load(i);
    if (!view) return view.error();
    const double known = median_deviation(**view);
    if (known > 0.0) medians.push_back(known);
    inputs.samples += (*view)->sample_count();
    quality.refined |= (*view)->samples == SampleOrigin::kRefined;
    if (hashed) inputs.hashes.push_back(hash_of_view(**view));
    if (const auto kept = check(memory); !kept) return kept.error();
  }
  quality.deviation = median(std::move(medians));
  return inputs;
}

// Of all samples: worth a note.
constexpr double kManyNoisy = 0.01;

// `samples`: of all views.
void count_samples(const std::vector<ViewSampler>& views, std::size_t samples,
                   MergeResult& result) {
  for (const ViewSampler& view : views) {
    result.flying_samples += view.flying();
    result.filled_samples += view.filled();
    result.noisy_samples += view.noisy();
  }
  if (static_cast<double>(result.noisy_samples) > kManyNoisy * static_cast<double>(samples))
    result.notes.push_back(std::to_string(result.noisy_samples) +
                           " samples are far noisier than the others, and than their spacing: they "
                           "tell which space is empty, not where the surface is");
}

// Refined views hold detail that a lattice as coarse as the samples blurs; in raw views there is
// only noise below the spacing (docs/results.md, Voxel size).
constexpr double kRefinedVoxel = 0.8;  // [sample spacings]

// So many times as coarse as the finest view, a lattice loses detail that is worth a note.
constexpr double kMuchCoarser = 2.0;

void note_lost_detail(const std::vector<double>& spacings, MergeResult& result) {
  const auto [finest, coarsest] = std::minmax_element(spacings.begin(), spacings.end());
  if (!(result.voxel_size > kMuchCoarser * *finest)) return;
  std::ostringstream note;
  note << std::setprecision(2) << "the sample spacings of the views are from " << *finest << " to "
       << *coarsest << ", and voxels are as large as in the typical view, " << result.voxel_size
       << ": --voxel-size " << *finest << " keeps the detail of the finest";
  result.notes.push_back(note.str());
}

void choose_scales(const std::vector<ViewSampler>& views, const MergeOptions& options, bool refined,
                   const RangeErrors& errors, MergeResult& result) {
  std::vector<double> spacings, noises;
  for (const ViewSampler& view : views) {
    spacings.push_back(view.spacing());
    noises.push_back(view.noise());
  }
  result.view_noise = median(noises);
  result.voxel_size = options.voxel_size > 0.0 ? options.voxel_size
                                               : (refined ? kRefinedVoxel : 1.0) * median(spacings);
  if (options.voxel_size == 0.0) note_lost_detail(spacings, result);
  result.inter_view_stddev = errors.stddev;
  result.range_exponent = errors.exponent;
  const double deviation = std::max(result.view_noise, result.inter_view_stddev);
  result.truncation =
      options.truncation > 0.0
          ? options.truncation
          : std::max(3.0 * result.voxel_size, kTruncatedDeviations * deviation + result.voxel_size);
}

void note_files_in_memory(const MemoryLimit* limit, std::vector<std::string>& notes) {
  if (limit && limit->folder_is_memory())
    notes.push_back("temporary files in " + limit->folder().string() +
                    " lie in memory themselves: the limit spares the machine nothing");
}

// All of the zero set. The field, the largest thing there is, is gone afterwards.
Result<TriangleMesh> closed_surface(const std::vector<ViewSampler>& views, const FieldUnits& units,
                                    MergeResult& result, MemoryLimit* memory,
                                    const Progress& progress) {
  ClosedFieldOptions field_options;
  field_options.voxel_size = result.voxel_size;
  field_options.truncation = result.truncation;
  field_options.memory = memory;
  field_options.units = units;
  const auto field =
      compute_closed_field(views, field_options, part_of(progress, kPrepared, kField));
  if (!field) return field.error();
  result.moving_blocks = field->moving_blocks;
  if (field->moving_blocks > 0)
    result.notes.push_back("the surface between the views is not final: in " +
                           std::to_string(field->moving_blocks) +
                           " blocks of voxels it still moved when its sweeps ended");
  if (!report_progress(progress, kField, "extract"))
    return Error{ErrorKind::kInterrupted, "merging was interrupted"};
  TriangleMesh mesh = extract_isosurface(field->finest(), memory);
  if (const auto kept = check(memory); !kept) return kept.error();
  return mesh;
}

// Of all samples on a surface: so many on components that are left out are worth a note.
constexpr double kMuchRemoved = 0.02;

void remove_components(const std::vector<ViewSampler>& views, MergeResult& result) {
  const MeasuredComponents found = keep_measured_components(views, result.truncation, result.mesh);
  result.components_removed = found.removed.components;
  result.faces_removed = found.removed.faces;
  std::ostringstream note;
  if (found.kept > 1)
    note << "the model is of " << found.kept
         << " components, apart from each other: more than a twentieth of the samples lie on each";
  if (found.removed_samples >= kMuchRemoved)
    note << (found.kept > 1 ? "; " : "") << std::lround(100.0 * found.removed_samples)
         << " % of the samples lie on " << found.removed.components
         << (found.removed.components == 1 ? " component that is" : " components that are")
         << " left out; --keep-components keeps all";
  if (!note.str().empty()) result.notes.push_back(note.str());
}

bool opens_holes(const MergeOptions& options) {
  return options.keep_holes || options.largest_fill > 0.0;
}

Error failed_check(const MeshCheck& check) {
  std::ostringstream message;
  message << "the merged surface is no closed manifold (" << check.faces << " faces, "
          << check.boundary_edges << " boundary edges, " << check.non_manifold_edges
          << " non-manifold edges, " << check.non_manifold_vertices << " non-manifold vertices, "
          << check.degenerate_faces << " degenerate faces, " << check.duplicate_vertices
          << " duplicate vertices, volume " << check.volume << "); try another voxel size";
  return {ErrorKind::kUnsolvable, message.str()};
}

Result<MergeResult> merge(const ViewSource& views, const MergeOptions& options,
                          const Context& context) {
  const Error interrupted{ErrorKind::kInterrupted, "merging was interrupted"};
  MergeResult result;
  if (!report_progress(context.progress, 0.0, "merge")) return interrupted;
  MemoryLimit* const memory = current_memory_limit();
  note_files_in_memory(memory, result.notes);
  const auto inputs = look_at(views, context.store != nullptr, memory);
  if (!inputs) return inputs.error();
  const SampleQuality& quality = inputs->quality;
  const Progress preparing = part_of(context.progress, 0.0, kPrepared);
  PagedSurfaceOptions surfaces{.memory = memory};
  surfaces.weights.silhouette_ramp = options.silhouette_ramp;
  surfaces.weights.nominal_deviation = quality.deviation;
  auto prepared = prepare_samplers(views, options.voxel_size, surfaces, preparing);
  if (!prepared) return prepared.error();
  auto& [samplers, indices, left_out] = *prepared;
  result.notes.insert(result.notes.end(), left_out.begin(), left_out.end());
  release_freed_memory();
  count_samples(samplers, inputs->samples, result);
  RangeErrors errors = inter_view_errors(samplers);
  if (quality.deviation > 0.0) errors.exponent = 0.0;  // Views know theirs.
  for (ViewSampler& sampler : samplers) sampler.set_range_errors(errors);
  choose_scales(samplers, options, quality.refined, errors, result);

  const FieldUnits units(context.store, ContentHash().add(inputs->hashes, options).hex());
  auto mesh = closed_surface(samplers, units, result, memory, context.progress);
  if (!mesh) return mesh.error();
  result.mesh = std::move(mesh).value();
  release_freed_memory();
  if (!options.keep_components) remove_components(samplers, result);
  if (result.mesh.faces.empty())
    return Error{ErrorKind::kUnsolvable,
                 "no surface was found: the voxel size is too large for the object"};
  if (!report_progress(context.progress, kMesh, "turn edges along creases")) return interrupted;
  align_edges_with_creases(result.mesh, {result.voxel_size, result.view_noise});
  result.check = check_mesh(result.mesh);
  if (!result.check.watertight()) return failed_check(result.check);

  if (!report_progress(context.progress, kSurface, "measure the surface")) return interrupted;
  const VertexAttributeOptions measure{.truncation = result.truncation,
                                       .voxel_size = result.voxel_size,
                                       .view_stddev = std::max(result.view_noise, errors.stddev),
                                       .nominal_deviation = quality.deviation,
                                       .memory = memory,
                                       .view_indices = indices};
  set_vertex_attributes(result.mesh, samplers, measure);
  const FairFillOptions fair{result.truncation, result.voxel_size, memory};
  const Progress closing = part_of(context.progress, kMeasured, kMeasured);
  const auto notes = fair_holes(fair, samplers, result.mesh, result.check, closing);
  if (!notes) return notes.error();
  result.notes.insert(result.notes.end(), notes->begin(), notes->end());
  set_filled_quality(result.mesh);
  set_vertex_colours(result.mesh, samplers, measure);
  result.filled_area_fraction = filled_area_fraction(result.mesh);
  if (opens_holes(options)) {
    open_holes(result.mesh, options.keep_holes ? 0.0 : options.largest_fill);
    result.check = check_mesh(result.mesh);
  }
  if (const auto kept = check(memory); !kept) return kept.error();
  report_progress(context.progress, 1.0, "merge");
  return result;
}

}  // namespace

Result<MergeResult> merge_from_source(const ViewSource& views, const MergeOptions& options,
                                      const Context& context) {
  return run_in(context, [&] { return merge(views, options, context); });
}

Result<MergeResult> merge_views(const std::vector<RangeView>& views, const MergeOptions& options,
                                const Context& context) {
  // Pointers that own nothing.
  const auto load = [&](std::size_t i) -> Result<std::shared_ptr<const RangeView>> {
    return std::shared_ptr<const RangeView>(std::shared_ptr<void>(), &views[i]);
  };
  return merge_from_source({views.size(), load}, options, context);
}

}  // namespace relief::fusion
