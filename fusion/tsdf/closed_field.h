#pragma once

#include <memory>
#include <vector>

#include "fusion/tsdf/sparse_field.h"
#include "fusion/units/merge_units.h"
#include "fusion/views/view_sampler.h"
#include "relief/fusion/field_part.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"

namespace relief::fusion {

struct ClosedFieldOptions {
  double voxel_size = 0.0;  ///< Spacing of the finest lattice [unit], > 0.
  double truncation = 0.0;  ///< Views measure up to this distance from their surface [unit], > 0.
  /// Cells of the coarsest lattice, which is dense, along the longest side of the object. Bounds
  /// the time.
  int coarse_cells = 40;
  int max_sweeps = 1000;          ///< Of the solver, on each lattice; it ends when all values rest.
  MemoryLimit* memory = nullptr;  ///< Of the fields; may be null, else it outlives them.
  /// Keeps all levels but the finest, which has four times the values of all others together.
  FieldUnits units;
};

/// A signed function on all of space, positive outside of the object and far away, whose zero set
/// is the closed surface; fields from the finest to the coarsest, each reading the next.
struct ClosedField {
  std::vector<std::unique_ptr<SparseField>> levels;
  /// Blocks, over all levels, in which values still changed when the solver's sweeps ended; 0: the
  /// field is what its equations say, to the solver's tolerance.
  std::size_t moving_blocks = 0;
  const SparseField& finest() const { return *levels.front(); }
};

/// Computes the field coarse to fine. Where views measured, it is their mean signed distance. In
/// between it is harmonic, but never less than the clearance that the views saw to be empty. Each
/// level covers the surroundings of the samples and of the next coarser level's zero set. An error
/// of the memory limit is returned when a level is done.
Result<ClosedField> compute_closed_field(const std::vector<ViewSampler>& views,
                                         const ClosedFieldOptions& options,
                                         const Progress& progress);

/// What compute_closed_field() finds in its units afterwards: the levels but the finest, and one
/// brick of that, integrated, unless `part` has no bricks. Returns the number of its groups of
/// blocks (field_integration.h). Levels are computed again where memory has no room for a unit.
Result<std::size_t> integrate_part_of_field(const std::vector<ViewSampler>& views,
                                            const FieldPart& part,
                                            const ClosedFieldOptions& options,
                                            const Progress& progress);

}  // namespace relief::fusion
