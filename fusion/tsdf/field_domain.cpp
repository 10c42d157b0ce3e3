#include "fusion/tsdf/field_domain.h"

#include <algorithm>
#include <climits>

#include <Eigen/Geometry>

#include "scan/base/parallel.h"
#include "scan/base/parallel_batches.h"

namespace relief::fusion {

namespace {

// The back of a sphere of which a third of the width was seen bulges by 1.1 of it, all told.
constexpr double kUnseen = 1.1;  // [widths]

// Cells round the zero set of a level that the next finer one covers. Where the finer zero set
// leaves them all the same, close_zero_set() adds blocks, with values of the coarser level.
constexpr int kBandCells = 2;

// Of which blocks are looked for side by side. Bound the memory; change no result.
constexpr std::size_t kViewsAtOnce = 64;
constexpr std::size_t kBlocksAtOnce = 2048;

Eigen::AlignedBox3d bounds_of(const std::vector<ViewSampler>& views, MemoryLimit* memory) {
  Eigen::AlignedBox3d box;
  for (const ViewSampler& view : views) {
    evict_pages(memory, view.bytes());
    box.extend(view.bounds());
  }
  return box;
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

// Adds all blocks between two.
void add_box(const Node& low, const Node& high, KeySet& blocks) {
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) blocks.add(key_of({x, y, z}));
}

}  // namespace

FieldDomain domain_of(const std::vector<ViewSampler>& views, double voxel_size, double truncation,
                      int coarse_cells, MemoryLimit* memory) {
  Eigen::AlignedBox3d box = bounds_of(views, memory);
  const double widest = box.sizes().maxCoeff();
  if (seen_from_one_side(views)) {
    // Behind, the object goes on as far as it is wide.
    const Eigen::Vector3d unseen = (kUnseen * widest - box.sizes().array()).matrix();
    box.min() -= unseen;
    box.max() += unseen;
  }
  FieldDomain domain;
  domain.finest.spacing = voxel_size;
  const double longest = widest + 2.0 * truncation;
  while (std::ldexp(voxel_size, domain.levels - 1) * coarse_cells < longest) ++domain.levels;
  const double coarse = std::ldexp(voxel_size, domain.levels - 1);
  const double padding = std::max(kPaddingCells * coarse, truncation + 2.0 * coarse);
  domain.finest.origin = box.min() - Eigen::Vector3d::Constant(padding);
  domain.coarse_cells = ((box.sizes().array() + 2.0 * padding) / coarse).ceil().cast<int>();
  return domain;
}

std::vector<NodeKey> blocks_near(const std::vector<ViewSampler>& views, const Lattice& lattice,
                                 double reach, MemoryLimit* memory) {
  const auto block_at = [&](const Eigen::Vector3d& p) -> Node {
    return (lattice.coordinates(p) / kBlockSide).array().floor().cast<int>();
  };
  const auto blocks_of = [&](const ViewSampler& view) {
    evict_pages(memory, 2 * view.bytes());
    KeySet blocks;
    Node last_low = Node::Constant(INT_MAX), last_high = last_low;
    view.for_surface_points([&](const Eigen::Vector3d& p) {
      const Node low = block_at(p - Eigen::Vector3d::Constant(reach));
      const Node high = block_at(p + Eigen::Vector3d::Constant(reach));
      if (low == last_low && high == last_high) return;
      last_low = low, last_high = high;
      add_box(low, high, blocks);
    });
    return blocks.take();
  };
  KeySet all;
  parallel_map_in_batches<std::vector<NodeKey>>(
      views.size(), kViewsAtOnce, [&](std::size_t i) { return blocks_of(views[i]); },
      [&](std::size_t, const std::vector<NodeKey>& blocks) { all.add(blocks); });
  return all.take();
}

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

std::vector<NodeKey> finer_blocks_near_zero(const SparseField& field, MemoryLimit* memory) {
  const auto near_zero_of = [&](std::size_t b) {
    KeySet blocks;
    if (!field.active(b)) return blocks.take();
    SparseField::Padded padded;
    field.gather(b, padded);
    for (int i = 0; i < kBlockNodes; ++i) {
      const Node local = node_at_offset(i);
      if (!crossed_cell(padded, local)) continue;
      const Node cell = field.first_node(b) + local;
      add_box(block_of(2 * (cell - Node::Constant(kBandCells))),
              block_of(2 * (cell + Node::Constant(kBandCells + 1))), blocks);
    }
    return blocks.take();
  };
  KeySet all;
  for (std::size_t first = 0; first < field.block_count(); first += kBlocksAtOnce) {
    const std::size_t count = std::min(kBlocksAtOnce, field.block_count() - first);
    std::vector<std::vector<NodeKey>> found(count);
    parallel_for(count, 16, [&](std::size_t begin, std::size_t end) {
      evict_pages(memory);
      for (std::size_t b = begin; b < end; ++b) found[b] = near_zero_of(first + b);
    });
    for (const auto& blocks : found) all.add(blocks);
  }
  return all.take();
}

}  // namespace relief::fusion
