#include "fusion/tsdf/field_integration.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Of a group as a unit: its blocks, their bytes, and those of the field.
constexpr std::size_t kGroupBytes = 3 * kBlocksOfGroup * kBlockNodes * 2 * sizeof(float);
constexpr std::size_t kBlocksNearby = 32;  // In a row of the field: seen by few of many views.

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

// The blocks of one group.
struct Group {
  std::size_t begin, end;

  Group(const SparseField& field, std::size_t number)
      : begin(number * kBlocksOfGroup),
        end(std::min(begin + kBlocksOfGroup, field.block_count())) {}
};

void integrate_group(const std::vector<ViewSampler>& views, const Group& group,
                     const FieldIntegrationOptions& options, SparseField& field,
                     PagedArray<NodeConstraint>& constraints) {
  parallel_for(group.end - group.begin, kBlocksNearby, [&](std::size_t first, std::size_t last) {
    evict_pages(options.memory);
    TsdfIntegrator integrator(views, options.truncation, field.lattice().spacing);
    integrator.narrow(box_of(field, group.begin + first, group.begin + last));
    for (std::size_t b = group.begin + first; b < group.begin + last; ++b)
      if (field.active(b)) integrate_block(b, integrator, options.limit, field, constraints);
  });
}

IntegratedBlocks integrated_blocks(const SparseField& field, const Group& group,
                                   const PagedArray<NodeConstraint>& constraints) {
  IntegratedBlocks integrated;
  for (std::size_t b = group.begin; b < group.end; ++b) {
    if (!field.active(b)) continue;
    integrated.values.insert(integrated.values.end(), field.values(b),
                             field.values(b) + kBlockNodes);
    for (std::size_t i = 0; i < kBlockNodes; ++i)
      integrated.floors.push_back(constraints[b * kBlockNodes + i].floor);
  }
  return integrated;
}

// False where these are not the blocks of the group.
bool put_back(const IntegratedBlocks& integrated, const Group& group, SparseField& field,
              PagedArray<NodeConstraint>& constraints) {
  std::size_t nodes = 0;
  for (std::size_t b = group.begin; b < group.end; ++b) nodes += field.active(b) ? kBlockNodes : 0;
  if (integrated.values.size() != nodes || integrated.floors.size() != nodes) return false;
  auto value = integrated.values.begin();
  auto floor = integrated.floors.begin();
  for (std::size_t b = group.begin; b < group.end; ++b) {
    if (!field.active(b)) continue;
    std::copy_n(value, kBlockNodes, field.values(b));
    for (std::size_t i = 0; i < kBlockNodes; ++i) constraints[b * kBlockNodes + i].floor = floor[i];
    value += kBlockNodes;
    floor += kBlockNodes;
  }
  return true;
}

}  // namespace

std::size_t group_count(const SparseField& field) {
  return (field.block_count() + kBlocksOfGroup - 1) / kBlocksOfGroup;
}

bool integrate_views(const std::vector<ViewSampler>& views, std::size_t begin, std::size_t end,
                     const FieldIntegrationOptions& options, const FieldUnits& units, bool keep,
                     SparseField& field, PagedArray<NodeConstraint>& constraints) {
  for (std::size_t number = begin; number < end; ++number) {
    if (options.go_on && !options.go_on(number)) return false;
    check_stop_and_memory();
    evict_pages(options.memory);
    const bool has_room = options.memory == nullptr || options.memory->has_room(kGroupBytes);
    const Group group(field, number);
    const auto kept = has_room ? units.find_group(number) : std::nullopt;
    if (kept && put_back(*kept, group, field, constraints)) continue;
    integrate_group(views, group, options, field, constraints);
    if (keep && has_room) units.keep_group(number, integrated_blocks(field, group, constraints));
  }
  return true;
}

}  // namespace relief::fusion
