#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/normals/convention_choice.h"
#include "scan/io/normals/normal_evidence.h"
#include "scan/io/project/loading/clipped_ranges.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// A view as read. Its `view.normals` stay empty until the convention of `normals` is settled.
struct LoadedView {
  RangeView view;
  std::optional<StoredNormals> normals;
  std::vector<std::string> notes;
  AssumedViewpoint assumed_viewpoint = AssumedViewpoint::kNone;
  std::optional<ClippedRanges> clipped;
};

/// Memory [bytes] that views may take together; may be used from several threads.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::size_t bytes) : MemoryBudget(bytes, bytes) {}
  /// `at_once`: what one view may take at most [bytes].
  MemoryBudget(std::size_t bytes, std::size_t at_once) : left_(bytes), at_once_(at_once) {}
  /// For one view.
  std::size_t left() const { return std::min<std::size_t>(left_, at_once_); }
  /// False when there is less: then nothing is taken.
  bool take(std::size_t bytes);

 private:
  std::atomic<std::size_t> left_;
  std::size_t at_once_;
};

/// Reads the data of one view, within `memory`. A view without any sample is an error
/// (kUnsolvable), as is one too large.
Result<LoadedView> load_view(const ViewSpec& spec, MemoryBudget& memory);

/// The same within the memory that is free.
Result<LoadedView> load_view(const ViewSpec& spec);

/// Gives the view its normals and frees the stored ones.
void set_normals(LoadedView& loaded, const ChosenConvention& chosen);

}  // namespace relief
