#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion/tsdf/sparse_field.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/unit_store.h"
#include "scan/units/content_hash.h"

namespace relief::fusion {

void hash_into(ContentHash& hash, const MergeOptions& options);

/// One level of a closed field, computed.
struct KeptLevel {
  SparseFieldBlocks blocks;
  std::size_t moving_blocks = 0;  ///< See ClosedField.
  bool bent = false;              ///< Whether its filled surface was bent (close_curved()).
};

/// What all views say of the active blocks of one group of the finest level, in order.
struct IntegratedBlocks {
  std::vector<float> values;  ///< kBlockNodes per block [unit].
  std::vector<float> floors;  ///< Of NodeConstraint, as many [unit]; NaN: fixed.
};

/// What is kept of one closed field as units of work (docs/cache.md): its levels but the finest,
/// and of that one groups of blocks with what the views say of them.
class FieldUnits {
 public:
  /// Keeps nothing.
  FieldUnits() = default;
  /// `inputs`: the hash of all that the field depends on. `store` may be null.
  FieldUnits(UnitStore* store, std::string inputs) : store_(store), inputs_(std::move(inputs)) {}

  /// What was kept of `level`, if anything.
  std::optional<KeptLevel> find(int level) const;
  void keep(int level, const SparseField& field, std::size_t moving_blocks, bool bent) const;

  /// What was kept of a group of blocks of the finest level, if anything.
  std::optional<IntegratedBlocks> find_group(std::size_t number) const;
  void keep_group(std::size_t number, const IntegratedBlocks& integrated) const;

 private:
  UnitStore* store_ = nullptr;
  std::string inputs_;
};

}  // namespace relief::fusion
