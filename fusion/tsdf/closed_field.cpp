#include "fusion/tsdf/closed_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include <Eigen/Geometry>

#include "fusion/tsdf/curved_closing.h"
#include "fusion/tsdf/field_domain.h"
#include "fusion/tsdf/field_integration.h"
#include "fusion/tsdf/obstacle_solver.h"

namespace relief::fusion {

namespace {

// A part of the progress of a computation: from `begin` to `end`.
struct ProgressPart {
  const Progress& progress;
  double begin, end;

  bool operator()(double fraction) const {
    return report_progress(progress, begin + fraction * (end - begin), "merge");
  }
};

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

const Error& interrupted() {
  static const Error error{ErrorKind::kInterrupted, "merging was interrupted"};
  return error;
}

// Where the levels are, and which of their blocks lie near samples.
struct LevelPlan {
  FieldDomain domain;
  std::vector<std::vector<NodeKey>> near_samples;
};

// One level before it is solved: the blocks near the samples and near the zero set of the next
// coarser field, with its values. Without such a field the lattice is the coarsest one, with all
// its blocks.
struct UnsolvedLevel {
  std::unique_ptr<SparseField> field;
  PagedArray<NodeConstraint> constraints;
  FieldIntegrationOptions integration;
};

UnsolvedLevel start_level(const LevelPlan& plan, int level, const SparseField* coarser,
                          const ClosedFieldOptions& options, const Progress& progress) {
  const Lattice lattice = plan.domain.lattice(level);
  const float limit = limit_of(lattice, options.truncation);
  std::vector<NodeKey> blocks;
  if (coarser) {
    blocks = plan.near_samples[static_cast<std::size_t>(level)];
    const auto near_zero = finer_blocks_near_zero(*coarser, options.memory);
    blocks.insert(blocks.end(), near_zero.begin(), near_zero.end());
    make_sorted_set(blocks);
  } else {
    blocks = all_blocks(plan.domain.coarse_cells);
  }
  UnsolvedLevel unsolved;
  unsolved.field =
      std::make_unique<SparseField>(lattice, std::move(blocks), coarser, limit, options.memory);
  unsolved.field->prolong(limit);
  unsolved.constraints =
      PagedArray<NodeConstraint>(unsolved.field->block_count() * kBlockNodes, options.memory);
  unsolved.integration.truncation = std::max(options.truncation, 2.0 * lattice.spacing);
  unsolved.integration.limit = limit;
  unsolved.integration.memory = options.memory;
  // Each level has four times the blocks of the one before.
  const ProgressPart part{progress, coarser ? std::ldexp(1.0, -2 * (level + 1)) : 0.0,
                          std::ldexp(1.0, -2 * level)};
  const auto groups = static_cast<double>(group_count(*unsolved.field));
  unsolved.integration.go_on = [part, groups](std::size_t group) {
    return part(static_cast<double>(group) / groups);
  };
  return unsolved;
}

// Groups of blocks are units on the finest level alone: the others are units themselves.
FieldUnits group_units(int level, const ClosedFieldOptions& options) {
  return level == 0 ? options.units : FieldUnits();
}

// Solves for the field on one lattice.
Result<FieldLevel> solve_level(const std::vector<ViewSampler>& views, const LevelPlan& plan,
                               int level, const SparseField* coarser, bool bent,
                               const ClosedFieldOptions& options, const Progress& progress) {
  UnsolvedLevel unsolved = start_level(plan, level, coarser, options, progress);
  PagedArray<NodeConstraint>& constraints = unsolved.constraints;
  const FieldIntegrationOptions& integration = unsolved.integration;
  FieldLevel solved{std::move(unsolved.field)};
  SparseField& field = *solved.field;
  const std::size_t groups = group_count(field);
  if (!integrate_views(views, 0, groups, integration, group_units(level, options), false, field,
                       constraints))
    return interrupted();
  if (coarser && bent) hold_far_blocks(field, constraints);
  if (!coarser) fix_outside(field, plan.domain.coarse_cells, integration.limit, constraints);
  bool stopped = false;
  ObstacleSolverOptions solver = solver_options(coarser == nullptr, options);
  solver.go_on = [&] { return !(stopped = !integration.go_on(groups)); };
  const auto solve = [&] {
    solved.moving_blocks = solve_obstacle_problem(field, constraints.span(), solver).moving_blocks;
  };
  solve();
  if (!stopped && (level > 0 || !coarser)) {
    const CurvedClosingOptions curved{.truncation = integration.truncation,
                                      .rounds = coarser ? 1 : kRoundsOfBending,
                                      .memory = options.memory};
    solved.bent = close_curved(field, views, constraints.span(), curved, solve);
  }
  if (stopped) return interrupted();
  solved.bent = solved.bent || bent;
  field.close_zero_set(integration.limit);
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
Result<FieldLevel> level_or_find(const std::vector<ViewSampler>& views, const LevelPlan& plan,
                                 int level, const SparseField* coarser, bool bent,
                                 const ClosedFieldOptions& options, const Progress& progress) {
  const std::size_t blocks = plan.near_samples[static_cast<std::size_t>(level)].size();
  const bool is_unit = level != 0 && room_for_unit(blocks, options.memory);
  if (auto kept = is_unit ? options.units.find(level) : std::nullopt) {
    const Lattice lattice = plan.domain.lattice(level);
    return FieldLevel{
        std::make_unique<SparseField>(lattice, std::move(kept->blocks), coarser,
                                      limit_of(lattice, options.truncation), options.memory),
        kept->moving_blocks, kept->bent};
  }
  auto solved = solve_level(views, plan, level, coarser, bent, options, progress);
  if (solved && is_unit)
    options.units.keep(level, *solved->field, solved->moving_blocks, solved->bent);
  return solved;
}

Result<LevelPlan> plan_levels(const std::vector<ViewSampler>& views,
                              const ClosedFieldOptions& options) {
  LevelPlan plan;
  plan.domain = domain_of(views, options.voxel_size, options.truncation, options.coarse_cells,
                          options.memory);
  if (!plan.domain.has_keys()) return too_many_voxels(views, options);
  plan.near_samples = {
      blocks_near(views, plan.domain.finest, 2.0 * options.voxel_size, options.memory)};
  while (static_cast<int>(plan.near_samples.size()) < plan.domain.levels)
    plan.near_samples.push_back(parents_of(plan.near_samples.back()));
  return plan;
}

// The levels from the coarsest to `finest`. Blocks near samples of these levels are gone from the
// plan afterwards.
Result<ClosedField> solve_levels(const std::vector<ViewSampler>& views, int finest, LevelPlan& plan,
                                 const ClosedFieldOptions& options, const Progress& progress) {
  ClosedField result;
  result.levels.resize(static_cast<std::size_t>(plan.domain.levels));
  const SparseField* coarser = nullptr;
  bool bent = false;
  for (int level = plan.domain.levels - 1; level >= finest; --level) {
    const auto l = static_cast<std::size_t>(level);
    auto solved = level_or_find(views, plan, level, coarser, bent, options, progress);
    if (!solved) return solved.error();
    plan.near_samples[l] = {};
    bent = solved->bent;
    result.moving_blocks += solved->moving_blocks;
    result.levels[l] = std::move(solved->field);
    coarser = result.levels[l].get();
    if (const auto kept = check(options.memory); !kept) return kept.error();
  }
  return result;
}

}  // namespace

Result<ClosedField> compute_closed_field(const std::vector<ViewSampler>& views,
                                         const ClosedFieldOptions& options,
                                         const Progress& progress) {
  auto plan = plan_levels(views, options);
  if (!plan) return plan.error();
  return solve_levels(views, 0, *plan, options, progress);
}

Result<std::size_t> integrate_part_of_field(const std::vector<ViewSampler>& views,
                                            const FieldPart& part,
                                            const ClosedFieldOptions& options,
                                            const Progress& progress) {
  auto plan = plan_levels(views, options);
  if (!plan) return plan.error();
  const auto coarse = solve_levels(views, 1, *plan, options, progress);
  if (!coarse) return coarse.error();
  if (part.bricks == 0) return 0;
  const SparseField* coarser = coarse->levels.size() > 1 ? coarse->levels[1].get() : nullptr;
  UnsolvedLevel unsolved = start_level(*plan, 0, coarser, options, progress);
  const std::size_t groups = group_count(*unsolved.field);
  const std::size_t begin = groups * part.brick / part.bricks;
  const std::size_t end = groups * (part.brick + 1) / part.bricks;
  unsolved.integration.go_on = [&, ask = unsolved.integration.go_on](std::size_t group) {
    return ask(groups * (group - begin) / (end - begin));
  };
  if (!integrate_views(views, begin, end, unsolved.integration, options.units, true,
                       *unsolved.field, unsolved.constraints))
    return interrupted();
  if (const auto kept = check(options.memory); !kept) return kept.error();
  return end - begin;
}

}  // namespace relief::fusion
