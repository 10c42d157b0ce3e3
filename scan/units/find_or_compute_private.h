#pragma once

#include <utility>

#include "relief/scan/result.h"
#include "relief/scan/unit_store.h"
#include "scan/base/parallel.h"
#include "scan/units/unit_codec_private.h"

namespace relief {

/// The value of one unit of work: from `store`, where it is kept under the key that `make_key()`
/// gives, else by `compute()`, a Result<Value>, and kept from then on. Errors are never kept.
/// Without a store there is no key to make.
template <typename Value, typename MakeKey, typename Compute>
Result<Value> find_or_compute(UnitStore* store, const MakeKey& make_key, const Compute& compute) {
  if (store == nullptr) return compute();
  const UnitKey key = make_key();
  if (auto content = store->find(key)) {
    check_stop_and_memory();
    if (auto value = decode_unit<Value>(std::move(*content))) return std::move(*value);
  }
  Result<Value> computed = compute();
  if (computed) keep_unit(*store, key, *computed);
  return computed;
}

}  // namespace relief
