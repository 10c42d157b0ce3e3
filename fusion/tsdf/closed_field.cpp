#include "fusion/tsdf/closed_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include <Eigen/Geometry>

#include "fusion/tsdf/curved_closing.h"
#include "fusion/tsdf/field_domain.h"
#include "fusion/tsdf/obstacle_solver.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// From the first to the last node of a block.
Eigen::AlignedBox3d box_of(const SparseField& field, std::size_t b) {
  const Node first = field.first_node(b);
  return {field.lattice().position(first),
          field.lattice().position(first + Node::Constant(kBlockSide - 1))};
}

// The box of several blocks; empty where none is active.
Eigen::AlignedBox3d box_of(const SparseField& field, std::size_t begin, std::size_t end) {
  Eigen::AlignedBox3d box;
  for (std::size_t b = begin; b < end; ++b)
    if (field.active(b)) box.extend(box_of(field, b));
  return box;
}

// Sets the nodes of a block that views measured to their distance and bounds the others from below
// by what is known empty.
void integrate_block(std::size_t b, TsdfIntegrator& integrator, double limit, SparseField& field,
                     PagedArray<NodeConstraint>& constraints) {
  float* values = field.values(b);
  integrator.focus(box_of(field, b));
  for (int i = 0; i < kBlockNodes; ++i) {
    if (i % kBlockSide == 0) check_stop_and_memory();  // A coarse block sees much of all views.
    NodeConstraint& constraint = constraints[b * kBlockNodes + static_cast<std::size_t>(i)];
    const TsdfSample sample = integrator.collect_as_far_as(
        limit, field.lattice().position(field.first_node(b) + node_at_offset(i)));
    if (sample.measured) {
      constraint = kFixedNode;
      values[i] = static_cast<float>(std::min(sample.distance, limit));
    } else {
      constraint.floor =
          static_cast<float>(sample.clearance > 0.0 ? std::min(sample.clearance, limit) : -limit);
      values[i] = std::max(values[i], constraint.floor);
    }
  }
}

// A part of the progress of a computation: from `begin` to `end`.
struct ProgressPart {
  const Progress& progress;
  double begin, end;

  bool operator()(double fraction) const {
    return report_progress(progress, begin + fraction * (end - begin), "merge");
  }
};

// Integrates the views into all blocks. False when `progress` asks to stop.
bool integrate_views(SparseField& field, const std::vector<ViewSampler>& views, double truncation,
                     double limit, PagedArray<NodeConstraint>& constraints,
                     const ClosedFieldOptions& options, const ProgressPart& progress) {
  constexpr std::size_t kBlocksAtOnce = 4096;  // Of 512 nodes: about a second of work.
  constexpr std::size_t kBlocksNearby = 32;    // In a row of the field: seen by few of many views.
  const std::size_t count = field.block_count();
  for (std::size_t first = 0; first < count; first += kBlocksAtOnce) {
    if (!progress(static_cast<double>(first) / static_cast<double>(count))) return false;
    const std::size_t blocks = std::min(kBlocksAtOnce, count - first);
    parallel_for(blocks, kBlocksNearby, [&](std::size_t begin, std::size_t end) {
      evict_pages(options.memory);
      TsdfIntegrator integrator(views, truncation, field.lattice().spacing);
      integrator.narrow(box_of(field, first + begin, first + end));
      for (std::size_t b = first + begin; b < first + end; ++b)
        if (field.active(b)) integrate_block(b, integrator, limit, field, constraints);
    });
  }
  return true;
}

// The border of the domain is outside whatever the views say.
void fix_outside(SparseField& field, const Node& cells, float outside,
                 PagedArray<NodeConstraint>& constraints) {
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    if (!field.active(b)) continue;
    for (int i = 0; i < kBlockNodes; ++i) {
      const Node node = field.first_node(b) + node_at_offset(i);
      if ((node.array() > 0).all() && (node.array() < cells.array()).all()) continue;
      field.values(b)[i] = outside;
      constraints[b * kBlockNodes + static_cast<std::size_t>(i)] = kFixedNode;
    }
  }
}

// Holds the nodes of blocks at which, as at those beside them, nothing was measured and no floor is
// reached: waves short enough to be new on this level have died away there.
void hold_far_blocks(const SparseField& field, PagedArray<NodeConstraint>& constraints) {
  const auto of_block = [&](std::size_t b) {
    return constraints.span().subspan(b * kBlockNodes, kBlockNodes);
  };
  std::vector<std::uint8_t> known(field.block_count(), 0);
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    if (!field.active(b)) continue;
    const float* values = field.values(b);
    for (std::size_t i = 0; i < kBlockNodes && !known[b]; ++i) {
      const NodeConstraint& constraint = of_block(b)[i];
      known[b] = constraint.fixed() || constraint.floor >= values[i];
    }
  }
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    bool near = !field.active(b);
    for (int k = 0; k < 27 && !near; ++k) {
      const std::int32_t beside = field.neighbour(b, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      near = beside >= 0 && known[static_cast<std::size_t>(beside)];
    }
    if (!near) std::ranges::fill(of_block(b), kFixedNode);
  }
}

// On the coarsest lattice the relaxation factor is the optimum for its size; the finer ones start
// close to their solution and differ from it in short waves only.
ObstacleSolverOptions solver_options(bool coarsest, const ClosedFieldOptions& options) {
  ObstacleSolverOptions solver;
  solver.max_sweeps = options.max_sweeps;
  solver.memory = options.memory;
  if (coarsest) {
    const double cells = options.coarse_cells + 2.0 * kPaddingCells;
    solver.relaxation = 2.0 / (1.0 + std::sin(std::numbers::pi / cells));
  }
  return solver;
}

// Values beyond are cut to it: no view measures farther.
float limit_of(const Lattice& lattice, double truncation) {
  return static_cast<float>(std::max(truncation, 3.0 * lattice.spacing));
}

// Of up to eight steps each. The back of a sphere comes to rest in three.
constexpr int kRoundsOfBending = 4;

struct FieldLevel {
  std::unique_ptr<SparseField> field;
  std::size_t moving_blocks = 0;
  bool bent = false;  // On this level or a coarser one.
};

// Solves for the field on one lattice, on the blocks near the samples and near the zero set of the
// next coarser field. Without such a field the lattice is the coarsest one, with all its blocks.
Result<FieldLevel> solve_level(const std::vector<ViewSampler>& views, const FieldDomain& domain,
                               int level, std::vector<NodeKey> near_samples,
                               const SparseField* coarser, bool bent,
                               const ClosedFieldOptions& options, const Progress& progress) {
  const Error interrupted{ErrorKind::kInterrupted, "merging was interrupted"};
  const Lattice lattice = domain.lattice(level);
  const double truncation = std::max(options.truncation, 2.0 * lattice.spacing);
  const float limit = limit_of(lattice, options.truncation);
  // Each level has four times the blocks of the one before.
  const ProgressPart part{progress, coarser ? std::ldexp(1.0, -2 * (level + 1)) : 0.0,
                          std::ldexp(1.0, -2 * level)};

  std::vector<NodeKey> blocks = coarser ? std::move(near_samples) : all_blocks(domain.coarse_cells);
  if (coarser) {
    const auto near_zero = finer_blocks_near_zero(*coarser, options.memory);
    blocks.insert(blocks.end(), near_zero.begin(), near_zero.end());
    make_sorted_set(blocks);
  }
  FieldLevel solved;
  solved.field =
      std::make_unique<SparseField>(lattice, std::move(blocks), coarser, limit, options.memory);
  SparseField& field = *solved.field;
  field.prolong(limit);
  PagedArray<NodeConstraint> constraints(field.block_count() * kBlockNodes, options.memory);
  if (!integrate_views(field, views, truncation, limit, constraints, options, part))
    return interrupted;
  if (coarser && bent) hold_far_blocks(field, constraints);
  if (!coarser) fix_outside(field, domain.coarse_cells, limit, constraints);
  bool stopped = false;
  ObstacleSolverOptions solver = solver_options(coarser == nullptr, options);
  solver.go_on = [&] { return !(stopped = !part(1.0)); };
  const auto solve = [&] {
    solved.moving_blocks = solve_obstacle_problem(field, constraints.span(), solver).moving_blocks;
  };
  solve();
  if (!stopped && (level > 0 || !coarser)) {
    const CurvedClosingOptions curved{.truncation = truncation,
                                      .rounds = coarser ? 1 : kRoundsOfBending,
                                      .memory = options.memory};
    solved.bent = close_curved(field, views, constraints.span(), curved, solve);
  }
  if (stopped) return interrupted;
  solved.bent = solved.bent || bent;
  field.close_zero_set(limit);
  return solved;
}

// Whether a level can be written and read as a unit. It is in memory three times then: as the
// field, its blocks, and their bytes. Blocks near the zero set may be as many as those near
// samples.
bool room_for_unit(std::size_t blocks_near_samples, const MemoryLimit* memory) {
  constexpr std::size_t kBlock = std::size_t{3} * 2 * kBlockNodes * sizeof(float);
  return memory == nullptr || memory->has_room(kBlock * blocks_near_samples);
}

// Names the widest view: most often one is of another unit, or has a stray sample far away.
Error too_many_voxels(const std::vector<ViewSampler>& views, const ClosedFieldOptions& options) {
  double widest = 0.0;
  std::string name;
  for (const ViewSampler& view : views) {
    evict_pages(options.memory, view.bytes());
    const Eigen::AlignedBox3d box = view.bounds();
    const double width = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
    if (width <= widest) continue;
    widest = width;
    name = view.name();
  }
  std::ostringstream message;
  message << "the voxel size " << options.voxel_size
          << " is too small for what the views span; the widest, `" << name << "`, spans " << widest
          << ": check its unit and pose, or use a larger voxel size";
  return {ErrorKind::kUnsolvable, message.str()};
}

// solve_level() as a unit of work.
Result<FieldLevel> level_or_find(const std::vector<ViewSampler>& views, const FieldDomain& domain,
                                 int level, std::vector<NodeKey> near_samples,
                                 const SparseField* coarser, bool bent,
                                 const ClosedFieldOptions& options, const Progress& progress) {
  const bool is_unit = level != 0 && room_for_unit(near_samples.size(), options.memory);
  if (auto kept = is_unit ? options.units.find(level) : std::nullopt) {
    const Lattice lattice = domain.lattice(level);
    return FieldLevel{
        std::make_unique<SparseField>(lattice, std::move(kept->blocks), coarser,
                                      limit_of(lattice, options.truncation), options.memory),
        kept->moving_blocks, kept->bent};
  }
  auto solved =
      solve_level(views, domain, level, std::move(near_samples), coarser, bent, options, progress);
  if (solved && is_unit)
    options.units.keep(level, *solved->field, solved->moving_blocks, solved->bent);
  return solved;
}

}  // namespace

Result<ClosedField> compute_closed_field(const std::vector<ViewSampler>& views,
                                         const ClosedFieldOptions& options,
                                         const Progress& progress) {
  const FieldDomain domain = domain_of(views, options.voxel_size, options.truncation,
                                       options.coarse_cells, options.memory);
  if (!domain.has_keys()) return too_many_voxels(views, options);

  std::vector<std::vector<NodeKey>> near_samples{
      blocks_near(views, domain.finest, 2.0 * options.voxel_size, options.memory)};
  while (static_cast<int>(near_samples.size()) < domain.levels)
    near_samples.push_back(parents_of(near_samples.back()));

  ClosedField result;
  result.levels.resize(static_cast<std::size_t>(domain.levels));
  const SparseField* coarser = nullptr;
  bool bent = false;
  for (int level = domain.levels - 1; level >= 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    auto solved = level_or_find(views, domain, level, std::move(near_samples[l]), coarser, bent,
                                options, progress);
    if (!solved) return solved.error();
    bent = solved->bent;
    result.moving_blocks += solved->moving_blocks;
    result.levels[l] = std::move(solved->field);
    coarser = result.levels[l].get();
    if (const auto kept = check(options.memory); !kept) return kept.error();
  }
  return result;
}

}  // namespace relief::fusion
