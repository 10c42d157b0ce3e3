#include "relief/fusion/merge_views.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

#include <Eigen/Geometry>

#include "fusion/holes/fair_holes.h"
#include "fusion/holes/filled_regions.h"
#include "fusion/mesh/crease_edges.h"
#include "fusion/mesh/measured_components.h"
#include "fusion/mesh/remove_handles.h"
#include "fusion/mesh/small_handles.h"
#include "fusion/prepared_merge.h"
#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "fusion/surface/vertex_colours.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// How far merging is when views are prepared, when there is a field, a mesh, a mesh along creases,
// and when that is measured: parts of the time, on the twelve refined views of the demo.
constexpr double kPrepared = 0.08, kField = 0.65, kMesh = 0.75, kSurface = 0.94, kMeasured = 0.97;

// All of the zero set. The field, the largest thing there is, is gone afterwards.
Result<TriangleMesh> closed_surface(const std::vector<ViewSampler>& views, const FieldUnits& units,
                                    MergeResult& result, MemoryLimit* memory,
                                    const Progress& progress) {
  const auto field = compute_closed_field(views, field_options(result, units, memory),
                                          part_of(progress, kPrepared, kField));
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

// With fewer voxels along its longest side, a model is hardly more than a lump: a feature needs two
// to four voxels (docs/fusion.md, Limits), an eighth of it then.
constexpr double kFewVoxels = 32.0;
// [sample spacings] From here on raw views are merged with larger pixels (prepared_samplers.cpp):
// what they show in less is lost.
constexpr double kLargeVoxel = 8.0;

// Tells what a chosen voxel size loses of the object.
void note_large_voxels(double sample_spacing, MergeResult& result) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : result.mesh.vertices) box.extend(vertex);
  const Eigen::Vector3d voxels = box.sizes() / result.voxel_size;
  const bool few = voxels.maxCoeff() < kFewVoxels;
  if (!few && !(result.voxel_size > kLargeVoxel * sample_spacing)) return;
  std::ostringstream note;
  note << (few ? "warning: voxels of " : "voxels of ") << result.voxel_size << std::setprecision(2)
       << " are large: the model measures " << voxels.x() << " x " << voxels.y() << " x "
       << voxels.z() << " of them, and the samples are " << sample_spacing
       << " apart; what is finer than two voxels is lost, and --voxel 0 takes them by the samples";
  result.notes.push_back(note.str());
}

// A handle is an opening of two voxels at least, with twice as much of the object on either side of
// it as a plate needs (docs/fusion.md, Limits). Smaller ones are what the lattice makes of less.
constexpr double kSmallHandle = 8.0;  // [voxels]
// Where two surfaces come near each other a single handle may arise. So many do not by chance, if
// the patches with them are this part of the area.
constexpr long kManyHandles = 10;
constexpr double kMuchOfArea = 0.01;

// Tells of a surface full of holes that the object hardly has. `result.mesh` is closed.
void note_small_handles(MergeResult& result) {
  if (result.check.genus < kManyHandles) return;
  const SmallHandles small = find_small_handles(result.mesh, kSmallHandle * result.voxel_size);
  result.small_handles = small.count;
  if (static_cast<long>(small.count) < kManyHandles || small.area_fraction < kMuchOfArea) return;
  const Eigen::Vector3d size = small.region.sizes(), centre = small.region.center();
  std::ostringstream note;
  note << std::setprecision(4) << "of the " << result.check.genus << " handles of the model, "
       << small.count << " or more are within eight voxels, too small for those of an object; "
       << small.in_region << " of these are in a box of " << size.x() << " x " << size.y() << " x "
       << size.z() << " around (" << centre.x() << " " << centre.y() << " " << centre.z()
       << "); views disagree there by more than the truncation of " << result.truncation
       << ", or they see both sides of something thinner than two voxels of " << result.voxel_size
       << ": look at the poses and edges of the views there, leave out stray samples or one of "
          "the sides (masks), or try another --voxel";
  result.notes.push_back(note.str());
}

void remove_handles(const std::vector<ViewSampler>& views, const VertexAttributeOptions& measure,
                    MergeResult& result) {
  const auto emptiness = [&] {
    return [evidence = TsdfIntegrator(views, result.truncation, result.voxel_size)](
               const Eigen::Vector3d& point) mutable { return evidence.in_empty_space(point); };
  };
  result.handles_removed = remove_unmeasured_handles(
      result.mesh, {kSmallHandle * result.voxel_size, result.voxel_size, emptiness});
  if (result.handles_removed == 0) return;
  result.notes.push_back(std::to_string(result.handles_removed) +
                         (result.handles_removed == 1 ? " handle" : " handles") +
                         " within eight voxels, which no view measured or saw through, " +
                         (result.handles_removed == 1 ? "is" : "are") +
                         " removed; --keep-handles keeps all");
  result.check = check_mesh(result.mesh);
  set_vertex_attributes(result.mesh, views, measure);
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
  auto prepared = prepare_merge(views, options, context.store, memory,
                                part_of(context.progress, 0.0, kPrepared), result);
  if (!prepared) return prepared.error();
  const std::vector<ViewSampler>& samplers = prepared->samplers;
  auto mesh = closed_surface(samplers, prepared->units, result, memory, context.progress);
  if (!mesh) return mesh.error();
  result.mesh = std::move(mesh).value();
  release_freed_memory();
  if (!options.keep_components) remove_components(samplers, result);
  if (result.mesh.faces.empty())
    return Error{ErrorKind::kUnsolvable,
                 "no surface was found: the voxel size is too large for the object"};
  if (options.voxel_size > 0.0) note_large_voxels(prepared->sample_spacing, result);
  if (!report_progress(context.progress, kMesh, "turn edges along creases")) return interrupted;
  align_edges_with_creases(result.mesh, {result.voxel_size, result.view_noise});
  result.check = check_mesh(result.mesh);
  if (!result.check.watertight()) return failed_check(result.check);

  if (!report_progress(context.progress, kSurface, "measure the surface")) return interrupted;
  const VertexAttributeOptions measure{.truncation = result.truncation,
                                       .voxel_size = result.voxel_size,
                                       .view_stddev = view_stddev(result),
                                       .nominal_deviation = prepared->nominal_deviation,
                                       .memory = memory,
                                       .view_indices = prepared->indices};
  set_vertex_attributes(result.mesh, samplers, measure);
  if (!options.keep_handles && result.check.genus > 0) {
    remove_handles(samplers, measure, result);
    if (!result.check.watertight()) return failed_check(result.check);
  }
  note_small_handles(result);
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
  return merge_from_source(source_of(views), options, context);
}

}  // namespace relief::fusion
