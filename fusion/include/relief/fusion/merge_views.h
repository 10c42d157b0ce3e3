#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct MergeOptions {
  /// Spacing of the lattice the surface is extracted from [unit]; 0: the median sample spacing of
  /// the views, or 0.8 of it where views are refined.
  double voxel_size = 0.0;
  /// Views contribute to the signed distance up to this far from their surface [unit]; 0: three
  /// voxels, or, if that is more, one voxel and four standard deviations of the views' noise or of
  /// what their surfaces are apart by, whichever is larger.
  double truncation = 0.0;
  /// The weight of a sample grows from a view's silhouettes over this many pixels.
  int silhouette_ramp = 6;
  /// Leave the surface open where no view measured it. The result is then not watertight.
  bool keep_holes = false;
  /// Leave open, whole, the holes that reach farther than this from what was measured [unit], along
  /// the surface that would fill them; 0: no bound.
  double largest_fill = 0.0;
  /// Keep also the components that hardly any samples lie on: less than a twentieth of all.
  bool keep_components = false;
  /// Take all samples of views that others contradict. Else these count only where no other view
  /// measured.
  bool keep_contradicted = false;
  /// Keep also the handles within cubes of eight voxels that no view measured.
  bool keep_handles = false;
};

/// Views given one at a time, so that they need not all be in memory. `load(i)` is called twice for
/// each i below `count`, and once more for views that others contradict; its errors end the
/// merging.
struct ViewSource {
  std::size_t count = 0;
  std::function<Result<std::shared_ptr<const RangeView>>(std::size_t i)> load;
};

/// What merging did.
struct MergeSummary {
  double filled_area_fraction = 0.0;  ///< Of the area before holes are opened.
  double voxel_size = 0.0;            ///< As used [unit].
  double truncation = 0.0;            ///< As used [unit].
  double view_noise = 0.0;  ///< Median standard deviation of the views' white noise [unit].
  /// Standard deviation of the errors that views do not share, noise, calibration and poses, from
  /// how far their surfaces are apart [unit]; 0: they hardly overlap.
  double inter_view_stddev = 0.0;
  /// How these errors grow with the distance from the sensor, as this power of it; 0: not at all,
  /// or the views know the deviations of their samples.
  double range_exponent = 0.0;
  std::size_t flying_samples = 0;  ///< Taken away: they hang in the air between surfaces.
  std::size_t filled_samples = 0;  ///< Interpolated in small gaps of the views.
  /// With more noise than the sample spacing and ten times the typical noise of their view, such as
  /// those of far walls: they tell only which space is empty.
  std::size_t noisy_samples = 0;
  /// Names of the views that others contradict: more than a tenth of their samples, and twice as
  /// many as of the typical view, are far from where two or more others agree. A note tells.
  std::vector<std::string> contradicted_views;
  /// Blocks of 8 x 8 x 8 voxels where the field that closes the surface had not come to rest; 0: it
  /// had everywhere. A note tells.
  std::size_t moving_blocks = 0;
  /// Handles that lie within cubes of eight voxels, at least so many: hardly of the object. 0 where
  /// the model has fewer than ten handles. Of many a note tells.
  std::size_t small_handles = 0;
  std::size_t handles_removed = 0;  ///< Small ones that no view measured.
  std::size_t components_removed = 0;
  std::size_t faces_removed = 0;   ///< In the removed components.
  std::vector<std::string> notes;  ///< What the user should know, one line each.
};

struct MergeResult : MergeSummary {
  /// With quality (expected error; for filled vertices the distance to the nearest measured one),
  /// number of views, view with the largest weight, filled flag and normal of each vertex, and its
  /// colour if views have colours.
  TriangleMesh mesh;
  MeshCheck check;  ///< Of `mesh`.
};

/// Merges views, taken at their `world_from_view`, to one surface that is closed, edge- and
/// vertex-manifold, oriented outwards and of positive volume. The order of the views does not
/// matter. Views without samples or without a pose are left out, with a note.
///
/// The memory of the context is the resident memory of the whole process that merging keeps to; the
/// result does not depend on it. Merging takes more than the result's mesh and its check.
///
/// Errors, all kUnsolvable: no views, no view with both a pose and connected samples, a voxel size
/// far too small or too large for the object, a surface that fails its final check, or a memory
/// limit that is too low (the message tells what is needed); kCannotWrite when temporary files
/// cannot be made; kInterrupted.
Result<MergeResult> merge_views(const std::vector<RangeView>& views,
                                const MergeOptions& options = {}, const Context& context = {});
Result<MergeResult> merge_from_source(const ViewSource& views, const MergeOptions& options = {},
                                      const Context& context = {});

}  // namespace relief::fusion
