#include "fusion/merge_views.h"

#include <algorithm>
#include <sstream>

#include "fusion/closed_field.h"
#include "fusion/filled_regions.h"
#include "fusion/isosurface.h"
#include "fusion/vertex_attributes.h"
#include "fusion/view_sampler.h"
#include "scan/median.h"
#include "scan/median_deviation.h"
#include "scan/mesh_components.h"

namespace relief {

namespace {

// A single view has nothing to be aligned with: any pose serves.
bool usable(const RangeView& view, std::size_t count) {
  return count == 1 || view.pose != PoseKind::kAbsent;
}

// The median of the views' median deviations; 0 when no view knows any.
double typical_deviation(const std::vector<RangeView>& views) {
  std::vector<double> medians;
  for (const RangeView& view : views) {
    const double known = median_deviation(view);
    if (known > 0.0) medians.push_back(known);
  }
  return median(std::move(medians));
}

Result<std::vector<ViewSampler>> prepare(const std::vector<RangeView>& views,
                                         const MergeOptions& options, double nominal_deviation,
                                         std::vector<std::string>& notes) {
  if (views.empty()) return Error{ErrorKind::kUnsolvable, "there are no views to merge"};
  QuadSurfaceOptions surface_options;
  surface_options.silhouette_ramp = options.silhouette_ramp;
  surface_options.threads = options.threads;
  surface_options.nominal_deviation = nominal_deviation;
  std::vector<ViewSampler> samplers;
  std::size_t without_pose = 0;
  for (const RangeView& view : views) {
    if (!usable(view, views.size())) {
      ++without_pose;
      notes.push_back("view `" + view.name + "` has no pose and is left out; align it first");
      continue;
    }
    auto sampler = ViewSampler::create(view, surface_options);
    if (!sampler) return sampler.error();
    if (sampler->empty())
      notes.push_back("view `" + view.name + "` has no connected samples and is left out");
    else
      samplers.push_back(std::move(sampler).value());
  }
  if (!samplers.empty()) return samplers;
  if (without_pose == views.size())
    return Error{ErrorKind::kUnsolvable, "no view has a pose: align the views before merging"};
  return Error{ErrorKind::kUnsolvable, "no view with a pose has connected samples to merge"};
}

// Refined views, those that know their deviations, hold detail that a lattice as coarse as the
// samples blurs; in views as measured there is only noise below the spacing (docs/fusion.md).
constexpr double kRefinedVoxel = 0.8;  // [sample spacings]

void choose_scales(const std::vector<ViewSampler>& views, const MergeOptions& options, bool refined,
                   MergeResult& result) {
  std::vector<double> spacings, noises;
  for (const ViewSampler& view : views) {
    spacings.push_back(view.spacing());
    noises.push_back(view.noise());
  }
  result.view_noise = median(noises);
  result.voxel_size = options.voxel_size > 0.0 ? options.voxel_size
                                               : (refined ? kRefinedVoxel : 1.0) * median(spacings);
  result.truncation =
      options.truncation > 0.0
          ? options.truncation
          : std::max(3.0 * result.voxel_size, 4.0 * result.view_noise + result.voxel_size);
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

}  // namespace

Result<MergeResult> merge_views(const std::vector<RangeView>& views, const MergeOptions& options,
                                const Progress& progress) {
  const Error interrupted{ErrorKind::kInterrupted, "merging was interrupted"};
  MergeResult result;
  if (!report_progress(progress, 0.0, "merge")) return interrupted;
  const double deviation = typical_deviation(views);
  const auto samplers = prepare(views, options, deviation, result.notes);
  if (!samplers) return samplers.error();
  choose_scales(*samplers, options, deviation > 0.0, result);

  ClosedFieldOptions field_options;
  field_options.voxel_size = result.voxel_size;
  field_options.truncation = result.truncation;
  field_options.threads = options.threads;
  const auto field = compute_closed_field(*samplers, field_options, progress);
  if (!field) return field.error();

  if (!report_progress(progress, 0.85, "extract")) return interrupted;
  result.mesh = extract_isosurface(field->finest(), options.threads);
  if (!options.keep_components) {
    const RemovedComponents removed = keep_largest_component(result.mesh);
    result.components_removed = removed.components;
    result.faces_removed = removed.faces;
  }
  if (result.mesh.faces.empty())
    return Error{ErrorKind::kUnsolvable,
                 "no surface was found: the voxel size is too large for the object"};
  result.check = check_mesh(result.mesh);
  if (!result.check.watertight()) return failed_check(result.check);

  if (!report_progress(progress, 0.9, "measure the surface")) return interrupted;
  set_vertex_attributes(result.mesh, *samplers,
                        {result.truncation, result.voxel_size, result.view_noise, options.threads});
  result.filled_area_fraction = filled_area_fraction(result.mesh);
  if (opens_holes(options)) {
    open_holes(result.mesh, options.keep_holes ? 0.0 : options.largest_fill);
    result.check = check_mesh(result.mesh);
  }
  report_progress(progress, 1.0, "merge");
  return result;
}

}  // namespace relief
