#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fusion/tsdf/lattice.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

inline constexpr int kBlockSide = 8;  // [nodes]
inline constexpr int kBlockNodes = kBlockSide * kBlockSide * kBlockSide;

/// The block that holds a node.
inline Node block_of(const Node& node) { return {node.x() >> 3, node.y() >> 3, node.z() >> 3}; }
/// The place of a node inside its block.
inline int offset_in_block(const Node& node) {
  return (node.x() & 7) | ((node.y() & 7) << 3) | ((node.z() & 7) << 6);
}
inline Node node_at_offset(int offset) {
  return {offset & 7, (offset >> 3) & 7, (offset >> 6) & 7};
}

/// All that is stored of a SparseField: one entry per block, border blocks among them.
struct SparseFieldBlocks {
  std::vector<NodeKey> keys;         ///< Ascending.
  std::vector<std::uint8_t> active;  ///< 0: of the border.
  std::vector<float> values;         ///< kBlockNodes per block.

  bool consistent() const {
    return active.size() == keys.size() && values.size() == keys.size() * kBlockNodes;
  }
};

/// A scalar function on a lattice, stored on blocks of 8 x 8 x 8 nodes in order of their keys. Some
/// blocks are active, where the function is computed; the others border them, one block wide, and
/// hold values carried over from a coarser field. Memory is proportional to the number of blocks.
class SparseField {
 public:
  /// `coarser` (twice the spacing, same origin, or null) gives the values outside the stored blocks
  /// and must outlive this field; without it they are `outside_value`. `active_blocks` is a sorted
  /// set of block keys. A field that has a coarser one gets its values by prolong(). Under a limit
  /// of memory (may be null) values are paged.
  SparseField(const Lattice& lattice, std::vector<NodeKey> active_blocks,
              const SparseField* coarser, float outside_value, MemoryLimit* memory = nullptr);
  /// The field whose blocks() were `blocks`, which are consistent.
  SparseField(const Lattice& lattice, SparseFieldBlocks blocks, const SparseField* coarser,
              float outside_value, MemoryLimit* memory = nullptr);

  const Lattice& lattice() const { return lattice_; }
  std::size_t block_count() const { return keys_.size(); }
  Node block(std::size_t b) const { return node_of(keys_[b]); }
  bool active(std::size_t b) const { return active_[b] != 0; }
  SparseFieldBlocks blocks() const;
  /// First node of a block.
  Node first_node(std::size_t b) const { return kBlockSide * block(b); }

  /// The index of a stored block; -1 if there is none.
  std::int32_t find(const Node& block) const;
  /// The index of the stored block at `block(b)` + (dx, dy, dz), each -1 to 1; -1 if none.
  std::int32_t neighbour(std::size_t b, int dx, int dy, int dz) const {
    return neighbours_[b][static_cast<std::size_t>((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1))];
  }

  float* values(std::size_t b) { return values_.data() + b * kBlockNodes; }
  const float* values(std::size_t b) const { return values_.data() + b * kBlockNodes; }

  /// The function at any node of the lattice: the stored value, else the coarser field
  /// interpolated.
  float value(const Node& node) const;
  /// The function at a node of the next finer lattice, trilinear.
  float value_at_finer(const Node& finer_node) const;

  /// Fills all stored blocks with the coarser field, clamped to +-`limit`.
  void prolong(float limit);

  /// The values on the nodes -1 to 8 of an active block: itself and one layer of its neighbours.
  using Padded = std::array<float, 1000>;
  void gather(std::size_t b, Padded& padded) const;

  /// Makes border blocks active, with the values they hold, until every cell that the zero set
  /// passes through and that touches an active block has all its nodes in active blocks: the zero
  /// set on the active blocks then has no border.
  void close_zero_set(float limit);

 private:
  void add_border();
  void clear_values();
  void link_neighbours();
  std::vector<NodeKey> crossed_border_blocks() const;
  void activate(const std::vector<NodeKey>& blocks, float limit);
  void prolong_block(std::size_t b, float limit);

  Lattice lattice_;
  const SparseField* coarser_;
  float outside_value_;
  std::vector<NodeKey> keys_;
  std::vector<std::uint8_t> active_;
  MemoryLimit* memory_;
  PagedArray<std::array<std::int32_t, 27>> neighbours_;  // See neighbour().
  PagedArray<float> values_;
};

/// Index of node (x, y, z), each -1 to 8 relative to the block, in a padded copy.
inline constexpr std::size_t padded_index(int x, int y, int z) {
  return static_cast<std::size_t>((x + 1) + 10 * (y + 1) + 100 * (z + 1));
}

/// Sorts and removes repetitions.
void make_sorted_set(std::vector<NodeKey>& keys);

/// A set of keys of which most are added many times: never holds many more than twice its own.
class KeySet {
 public:
  void add(NodeKey key) {
    keys_.push_back(key);
    if (keys_.size() >= next_) remove_repetitions();
  }
  void add(const std::vector<NodeKey>& keys) {
    for (const NodeKey key : keys) add(key);
  }
  /// The keys in ascending order, in no more memory than they need. The set is empty afterwards.
  std::vector<NodeKey> take();
  /// How many keys are held, with their repetitions.
  std::size_t held() const { return keys_.size(); }

 private:
  // Changes no result.
  static constexpr std::size_t kFewest = 65536;

  void remove_repetitions() {
    make_sorted_set(keys_);
    next_ = 2 * keys_.size() + kFewest;
  }

  std::vector<NodeKey> keys_;
  std::size_t next_ = kFewest;  // So many keys are looked at for repetitions.
};

}  // namespace relief::fusion
