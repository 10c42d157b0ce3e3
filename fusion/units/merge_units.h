#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

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

/// The levels of one closed field, kept as units of work (docs/cache.md).
class FieldUnits {
 public:
  /// Keeps nothing.
  FieldUnits() = default;
  /// `inputs`: the hash of all that the field depends on. `store` may be null.
  FieldUnits(UnitStore* store, std::string inputs) : store_(store), inputs_(std::move(inputs)) {}

  /// What was kept of `level`, if anything.
  std::optional<KeptLevel> find(int level) const;
  void keep(int level, const SparseField& field, std::size_t moving_blocks, bool bent) const;

 private:
  UnitStore* store_ = nullptr;
  std::string inputs_;
};

}  // namespace relief::fusion
