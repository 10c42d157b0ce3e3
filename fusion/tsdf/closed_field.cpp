#include "fusion/tsdf/closed_field.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "fusion/tsdf/obstacle_solver.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Free cells of the coarsest lattice on each side of the object. Fewer press what closes an open
// side against the border; twice as many make 1.7 times the nodes (60^3 / 50^3).
constexpr int kPaddingCells = 5;
// Cells round the zero set of a level that the next finer one covers. Where the finer zero set
// leaves them all the same, close_zero_set() adds blocks, with values of the coarser level.
constexpr int kBandCells = 2;

Eigen::AlignedBox3d bounds_of(const std::vector<ViewSampler>& views, MemoryLimit* memory) {
  Eigen::AlignedBox3d box;
  for (const ViewSampler& view : views) {
    evict_pages(memory, view.bytes());
    view.for_surface_points([&](const Eigen::Vector3d& p) { box.extend(p); });
  }
  return box;
}

// The blocks within `reach` of the views' samples.
std::vector<NodeKey> blocks_near(const std::vector<ViewSampler>& views, const Lattice& lattice,
                                 double reach, const ClosedFieldOptions& options) {
  std::vector<std::vector<NodeKey>> by_view(views.size());
  const auto block_at = [&](const Eigen::Vector3d& p) -> Node {
    return (lattice.coordinates(p) / kBlockSide).array().floor().cast<int>();
  };
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      evict_pages(options.memory, 2 * views[i].bytes());
      Node last_low = Node::Constant(INT_MAX), last_high = last_low;
      views[i].for_surface_points([&](const Eigen::Vector3d& p) {
        const Node low = block_at(p - Eigen::Vector3d::Constant(reach));
        const Node high = block_at(p + Eigen::Vector3d::Constant(reach));
        if (low == last_low && high == last_high) return;
        last_low = low, last_high = high;
        for (int z = low.z(); z <= high.z(); ++z)
          for (int y = low.y(); y <= high.y(); ++y)
            for (int x = low.x(); x <= high.x(); ++x) by_view[i].push_back(key_of({x, y, z}));
      });
      make_sorted_set(by_view[i]);
    }
  });
  std::vector<NodeKey> all;
  for (const auto& keys : by_view) all.insert(all.end(), keys.begin(), keys.end());
  make_sorted_set(all);
  return all;
}

// The blocks of the next coarser lattice that cover `blocks`.
std::vector<NodeKey> parents_of(const std::vector<NodeKey>& blocks) {
  std::vector<NodeKey> parents;
  parents.reserve(blocks.size());
  for (const NodeKey key : blocks) {
    const Node block = node_of(key);
    parents.push_back(key_of({block.x() >> 1, block.y() >> 1, block.z() >> 1}));
  }
  make_sorted_set(parents);
  return parents;
}

std::vector<NodeKey> all_blocks(const Node& cells) {
  std::vector<NodeKey> blocks;
  for (int z = 0; z <= cells.z() / kBlockSide; ++z)
    for (int y = 0; y <= cells.y() / kBlockSide; ++y)
      for (int x = 0; x <= cells.x() / kBlockSide; ++x) blocks.push_back(key_of({x, y, z}));
  make_sorted_set(blocks);
  return blocks;
}

bool crossed_cell(const SparseField::Padded& padded, const Node& n) {
  const bool first = padded[padded_index(n.x(), n.y(), n.z())] > 0.0f;
  for (int k = 1; k < 8; ++k) {
    const float corner =
        padded[padded_index(n.x() + (k & 1), n.y() + (k >> 1 & 1), n.z() + (k >> 2))];
    if ((corner > 0.0f) != first) return true;
  }
  return false;
}

// The blocks of the next finer lattice within kBandCells of the zero set of `field`.
std::vector<NodeKey> finer_blocks_near_zero(const SparseField& field,
                                            const ClosedFieldOptions& options) {
  std::vector<std::vector<NodeKey>> found(field.block_count());
  parallel_for(field.block_count(), 16, [&](std::size_t begin, std::size_t end) {
    evict_pages(options.memory);
    SparseField::Padded padded;
    for (std::size_t b = begin; b < end; ++b) {
      if (!field.active(b)) continue;
      field.gather(b, padded);
      for (int i = 0; i < kBlockNodes; ++i) {
        const Node local = node_at_offset(i);
        if (!crossed_cell(padded, local)) continue;
        const Node cell = field.first_node(b) + local;
        const Node low = block_of(2 * (cell - Node::Constant(kBandCells)));
        const Node high = block_of(2 * (cell + Node::Constant(kBandCells + 1)));
        for (int z = low.z(); z <= high.z(); ++z)
          for (int y = low.y(); y <= high.y(); ++y)
            for (int x = low.x(); x <= high.x(); ++x) found[b].push_back(key_of({x, y, z}));
      }
      make_sorted_set(found[b]);
    }
  });
  std::vector<NodeKey> all;
  for (const auto& keys : found) all.insert(all.end(), keys.begin(), keys.end());
  make_sorted_set(all);
  return all;
}

// From the first to the last node of a block.
Eigen::AlignedBox3d box_of(const SparseField& field, std::size_t b) {
  const Node first = field.first_node(b);
  return {field.lattice().position(first),
          field.lattice().position(first + Node::Constant(kBlockSide - 1))};
}

// Sets the nodes of a block that views measured to their distance and bounds the others from below
// by what is known empty.
void integrate_block(std::size_t b, TsdfIntegrator& integrator, double limit, SparseField& field,
                     PagedArray<NodeConstraint>& constraints) {
  float* values = field.values(b);
  integrator.focus(box_of(field, b));
  for (int i = 0; i < kBlockNodes; ++i) {
    NodeConstraint& constraint = constraints[b * kBlockNodes + static_cast<std::size_t>(i)];
    const TsdfSample sample = integrator.collect_as_far_as(
        limit, field.lattice().position(field.first_node(b) + node_at_offset(i)));
    if (sample.measured) {
      constraint = kFixedNode;
      values[i] = static_cast<float>(sample.distance);
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
  const std::size_t count = field.block_count();
  for (std::size_t first = 0; first < count; first += kBlocksAtOnce) {
    if (!progress(static_cast<double>(first) / static_cast<double>(count))) return false;
    const std::size_t blocks = std::min(kBlocksAtOnce, count - first);
    parallel_for(blocks, 4, [&](std::size_t begin, std::size_t end) {
      evict_pages(options.memory);
      TsdfIntegrator integrator(views, truncation, field.lattice().spacing);
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

struct Domain {
  Lattice finest;
  int levels = 1;
  Node coarse_cells = Node::Zero();

  Lattice lattice(int level) const { return {finest.origin, std::ldexp(finest.spacing, level)}; }
};

Domain domain_of(const Eigen::AlignedBox3d& box, const ClosedFieldOptions& options) {
  Domain domain;
  domain.finest.spacing = options.voxel_size;
  const double longest = box.sizes().maxCoeff() + 2.0 * options.truncation;
  while (std::ldexp(options.voxel_size, domain.levels - 1) * options.coarse_cells < longest)
    ++domain.levels;
  const double coarse = std::ldexp(options.voxel_size, domain.levels - 1);
  const double padding = std::max(kPaddingCells * coarse, options.truncation + 2.0 * coarse);
  domain.finest.origin = box.min() - Eigen::Vector3d::Constant(padding);
  domain.coarse_cells = ((box.sizes().array() + 2.0 * padding) / coarse).ceil().cast<int>();
  return domain;
}

}  // namespace

Result<ClosedField> compute_closed_field(const std::vector<ViewSampler>& views,
                                         const ClosedFieldOptions& options,
                                         const Progress& progress) {
  const Error interrupted{ErrorKind::kInterrupted, "merging was interrupted"};
  const Domain domain = domain_of(bounds_of(views, options.memory), options);
  if (!((domain.coarse_cells.cast<double>() * std::ldexp(1.0, domain.levels)).maxCoeff() <
        kKeyOffset))
    return Error{ErrorKind::kUnsolvable, "the voxel size is too small for the size of the object"};

  std::vector<std::vector<NodeKey>> near_samples{
      blocks_near(views, domain.finest, 2.0 * options.voxel_size, options)};
  while (static_cast<int>(near_samples.size()) < domain.levels)
    near_samples.push_back(parents_of(near_samples.back()));

  ClosedField result;
  result.levels.resize(static_cast<std::size_t>(domain.levels));
  for (int level = domain.levels - 1; level >= 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    const bool coarsest = level == domain.levels - 1;
    const SparseField* coarser = coarsest ? nullptr : result.levels[l + 1].get();
    const Lattice lattice = domain.lattice(level);
    const double truncation = std::max(options.truncation, 2.0 * lattice.spacing);
    const auto limit = static_cast<float>(std::max(truncation, 3.0 * lattice.spacing));
    // Each level has four times the blocks of the one before.
    const ProgressPart part{progress, coarsest ? 0.0 : std::ldexp(0.8, -2 * (level + 1)),
                            std::ldexp(0.8, -2 * level)};

    std::vector<NodeKey> blocks =
        coarsest ? all_blocks(domain.coarse_cells) : std::move(near_samples[l]);
    if (!coarsest) {
      const auto near_zero = finer_blocks_near_zero(*coarser, options);
      blocks.insert(blocks.end(), near_zero.begin(), near_zero.end());
      make_sorted_set(blocks);
    }
    result.levels[l] =
        std::make_unique<SparseField>(lattice, std::move(blocks), coarser, limit, options.memory);
    SparseField& field = *result.levels[l];
    field.prolong(limit);
    PagedArray<NodeConstraint> constraints(field.block_count() * kBlockNodes, options.memory);
    if (!integrate_views(field, views, truncation, limit, constraints, options, part))
      return interrupted;
    if (coarsest) fix_outside(field, domain.coarse_cells, limit, constraints);
    bool stopped = false;
    ObstacleSolverOptions solver = solver_options(coarsest, options);
    solver.go_on = [&] { return !(stopped = !part(1.0)); };
    result.moving_blocks += solve_obstacle_problem(field, constraints.span(), solver).moving_blocks;
    if (stopped) return interrupted;
    field.close_zero_set(limit);
    if (const auto kept = check(options.memory); !kept) return kept.error();
  }
  return result;
}

}  // namespace relief::fusion
