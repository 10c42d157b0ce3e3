#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// What stands still in the frame of a camera while the object turns before it: a wall, a table,
/// the frame of a turntable.
struct StaticBackground {
  /// By view, 1 for samples of the background; empty for views without any.
  std::vector<Grid<std::uint8_t>> masks;
  std::size_t samples = 0;  ///< Of the background, in all views.
  std::size_t views = 0;    ///< With background.
  /// Samples that stand still, too, but may as well belong to the object, such as those of a
  /// turned foot that looks the same from all sides. They are no background. Of many views those
  /// of 64 are counted.
  std::size_t undecided = 0;
};

/// Finds the background of views that share a camera, at least three. A surface that stands still
/// is background if
/// - the poses of the views, where they describe what moves, would have it elsewhere: other views
///   see through it there, with nothing within a tenth of the radius of what moves; or
/// - without such poses, if it reaches beyond what moves on three sides of the image or more and is
///   continuous with it nowhere, but for a twentieth of the pixels where both meet.
/// Nothing is found where nothing moves. Of many views some tell what stands still. The same for
/// any number of threads.
StaticBackground find_static_background(const std::vector<RangeView>& views);

/// Gives a view, of which ranges, camera and pose are used.
using LoadRanges = std::function<Result<std::shared_ptr<const RangeView>>(std::size_t view)>;

/// The same for views that are loaded one at a time. At most 64 are held at once. Errors are those
/// of `load`.
Result<StaticBackground> find_static_background(std::size_t views, const LoadRanges& load);

/// Takes the samples of the background out of the views.
void remove_background(const StaticBackground& background, std::vector<RangeView>& views);
/// The same for one view and its mask, which may be empty.
void remove_background(const Grid<std::uint8_t>& mask, RangeView& view);

/// What was found, one line each, for the user; `removed` says whether it was left out.
std::vector<std::string> describe(const StaticBackground& background, bool removed);

}  // namespace relief
