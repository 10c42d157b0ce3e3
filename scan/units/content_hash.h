#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/grid.h"
#include "relief/scan/unit_store.h"

namespace relief {

/// The SHA-256 of values, for the keys of units of work. Numbers count by their bits, and
/// everything with a length counts with it: different values never give the same bytes. A struct
/// takes part through a function `void hash_into(ContentHash&, const Struct&)` in its namespace,
/// which names every field in a structured binding: it fails to compile once a field is added.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(ContentHash&&) noexcept;
  ContentHash& operator=(ContentHash&&) noexcept;

  template <typename... Values>
  ContentHash& add(const Values&... values) {
    (add_one(values), ...);
    return *this;
  }

  ContentHash& add_bytes(const void* bytes, std::size_t count);

  /// 64 hexadecimal digits. Ends the hash.
  std::string hex();

 private:
  // Whether all bytes of a value tell, so that an array of them is hashed as it lies.
  template <typename T>
  struct IsBits : std::bool_constant<std::is_arithmetic_v<T>> {};
  template <typename S, int Rows, int Columns, int Options>
  struct IsBits<Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>>
      : std::bool_constant<Rows != Eigen::Dynamic && Columns != Eigen::Dynamic &&
                           sizeof(Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>) ==
                               sizeof(S) * Rows * Columns> {};
  template <typename T, std::size_t Count>
  struct IsBits<std::array<T, Count>> : IsBits<T> {};

  template <typename T>
  void add_array(const T* values, std::size_t count) {
    add_one(std::uint64_t{count});
    if constexpr (IsBits<T>::value) {
      add_bytes(values, count * sizeof(T));
    } else {
      for (std::size_t i = 0; i < count; ++i) add_one(values[i]);
    }
  }

  template <typename T>
  void add_one(const T& value) {
    if constexpr (std::is_enum_v<T> || std::is_integral_v<T>) {
      const auto wide = static_cast<std::uint64_t>(value);
      add_bytes(&wide, sizeof wide);
    } else if constexpr (IsBits<T>::value) {
      add_bytes(&value, sizeof value);
    } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
      const std::string_view text = value;
      add_array(text.data(), text.size());
    } else {
      hash_into(*this, value);
    }
  }
  template <typename T>
  void add_one(const std::optional<T>& value) {
    add_one(value.has_value());
    if (value) add_one(*value);
  }
  template <typename T, typename Allocator>
  void add_one(const std::vector<T, Allocator>& values) {
    add_array(values.data(), values.size());
  }
  void add_one(const std::vector<bool>& values) {
    add_one(std::uint64_t{values.size()});
    for (const bool value : values) add_one(value);
  }
  template <typename T>
  void add_one(const Grid<T>& grid) {
    add(grid.width(), grid.height());
    add_array(grid.data(), grid.size());
  }
  void add_one(const Eigen::Isometry3d& motion) { add_one(motion.matrix()); }

  struct Digest;
  std::unique_ptr<Digest> digest_;
};

/// SHA-256 of the program's own code and of the libraries it is linked with, by the build ids that
/// the linker gave them: another build may give other bytes, and finds nothing. 64 hexadecimal
/// digits, found once per process.
const std::string& program_identity();

/// The key of a unit of work from all that its result depends on. Kind, format and program are in
/// it, too: see program_identity(). Numbers of threads and limits of memory are never: they change
/// no result.
template <typename... Inputs>
UnitKey unit_key(std::string_view kind, const Inputs&... inputs) {
  ContentHash hash;
  hash.add(std::string_view("relief unit"), kUnitFormat, kind,
           std::string_view(program_identity()));
  hash.add(inputs...);
  return {std::string(kind), hash.hex()};
}

}  // namespace relief
