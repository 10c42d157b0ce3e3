#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace relief {

/// The format of kept units. It is part of every key: raised when the same inputs give other bytes,
/// or when a result is written in another way.
inline constexpr int kUnitFormat = 1;

/// Names the result of one unit of work, such as a view refined.
struct UnitKey {
  std::string kind;  ///< What was done, as `refine`: letters and underscores.
  std::string hash;  ///< SHA-256 of all that the result depends on, 64 hexadecimal digits.
};

/// Keeps the results of finished units of work for later computations, docs/cache.md. All functions
/// may be called from any thread. Where a function takes a pointer to a store, null means none, and
/// the result is the same to the bit with and without one.
class UnitStore {
 public:
  virtual ~UnitStore() = default;

  /// What was kept under this key. Nothing when there is none, or when it is damaged.
  virtual std::optional<std::string> find(const UnitKey& key) = 0;

  /// Keeps a result that was computed. A store that cannot do so says so in its own way: the
  /// computation goes on. One that takes long to write may be given up when the work is stopped.
  virtual void keep(const UnitKey& key, std::string_view content) = 0;
};

}  // namespace relief
