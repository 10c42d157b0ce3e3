#pragma once

#include <map>
#include <mutex>
#include <string>

#include "relief/scan/unit_store.h"

namespace relief::testing {

/// A store of units in memory that counts them by kind.
class MemoryStore : public UnitStore {
 public:
  std::optional<std::string> find(const UnitKey& key) override {
    const std::scoped_lock lock(mutex_);
    const auto unit = units.find(key.hash);
    if (unit == units.end()) return std::nullopt;
    ++found[key.kind];
    return unit->second;
  }
  void keep(const UnitKey& key, std::string_view content) override {
    const std::scoped_lock lock(mutex_);
    ++computed[key.kind];
    units[key.hash] = content;
    kinds[key.hash] = key.kind;
  }
  void forget(const std::string& kind) {
    std::erase_if(units, [&](const auto& unit) { return kinds[unit.first] == kind; });
  }
  void start_again() {
    found.clear();
    computed.clear();
  }

  std::map<std::string, std::string> units, kinds;  // By hash.
  std::map<std::string, int> found, computed;

 private:
  static inline std::mutex mutex_;  // Stores are copied.
};

}  // namespace relief::testing
