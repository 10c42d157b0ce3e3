#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <span>
#include <sstream>
#include <streambuf>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cereal/archives/binary.hpp>
#include <cereal/types/array.hpp>
#include <cereal/types/optional.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/utility.hpp>
#include <cereal/types/vector.hpp>

#include "relief/scan/grid.h"
#include "relief/scan/unit_store.h"
#include "scan/base/memory/paged_fill.h"

// How cereal writes the types of the data model: numbers by their bits, so that what is read is
// what was computed. For source files only.

namespace cereal {

template <class Archive, typename S, int Rows, int Columns, int Options>
void save(Archive& archive, const Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>& matrix) {
  if constexpr (Rows == Eigen::Dynamic || Columns == Eigen::Dynamic)
    archive(std::int64_t{matrix.rows()}, std::int64_t{matrix.cols()});
  archive(binary_data(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(S)));
}

template <class Archive, typename S, int Rows, int Columns, int Options>
void load(Archive& archive, Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>& matrix) {
  if constexpr (Rows == Eigen::Dynamic || Columns == Eigen::Dynamic) {
    std::int64_t rows = 0, columns = 0;
    archive(rows, columns);
    matrix.resize(rows, columns);
  }
  archive(binary_data(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(S)));
}

// All at once, with the bytes of one after the other: meshes have millions.
template <class Archive, typename S, int Rows, int Columns, int Options, typename Allocator>
requires(Rows != Eigen::Dynamic && Columns != Eigen::Dynamic) void save(
    Archive& archive,
    const std::vector<Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>, Allocator>&
        matrices) {
  static_assert(sizeof(matrices[0]) == sizeof(S) * Rows * Columns);
  archive(make_size_tag(static_cast<size_type>(matrices.size())));
  archive(binary_data(matrices.data(), matrices.size() * sizeof(matrices[0])));
}

template <class Archive, typename S, int Rows, int Columns, int Options, typename Allocator>
requires(Rows != Eigen::Dynamic && Columns != Eigen::Dynamic) void load(
    Archive& archive,
    std::vector<Eigen::Matrix<S, Rows, Columns, Options, Rows, Columns>, Allocator>& matrices) {
  size_type size = 0;
  archive(make_size_tag(size));
  matrices.resize(static_cast<std::size_t>(size));
  archive(binary_data(matrices.data(), matrices.size() * sizeof(matrices[0])));
}

template <class Archive, typename T, std::size_t Count, typename Allocator>
requires std::is_arithmetic_v<T>
void save(Archive& archive, const std::vector<std::array<T, Count>, Allocator>& arrays) {
  archive(make_size_tag(static_cast<size_type>(arrays.size())));
  archive(binary_data(arrays.data(), arrays.size() * sizeof(arrays[0])));
}

template <class Archive, typename T, std::size_t Count, typename Allocator>
requires std::is_arithmetic_v<T>
void load(Archive& archive, std::vector<std::array<T, Count>, Allocator>& arrays) {
  size_type size = 0;
  archive(make_size_tag(size));
  arrays.resize(static_cast<std::size_t>(size));
  archive(binary_data(arrays.data(), arrays.size() * sizeof(arrays[0])));
}

template <class Archive>
void save(Archive& archive, const Eigen::Isometry3d& motion) {
  archive(motion.matrix());
}

template <class Archive>
void load(Archive& archive, Eigen::Isometry3d& motion) {
  archive(motion.matrix());
}

template <class Archive, typename T>
void save(Archive& archive, const relief::Grid<T>& grid) {
  static_assert(std::is_trivially_destructible_v<T>);
  archive(grid.width(), grid.height());
  archive(binary_data(grid.data(), grid.size() * sizeof(T)));
}

template <class Archive, typename T>
void load(Archive& archive, relief::Grid<T>& grid) {
  int width = 0, height = 0;
  archive(width, height);
  if (width < 0 || height < 0) throw Exception("a grid of negative size");
  grid = relief::Grid<T>(width, height);
  archive(binary_data(grid.data(), grid.size() * sizeof(T)));
}

}  // namespace cereal

namespace relief {

/// Counts what is written to it.
class CountingBuffer : public std::streambuf {
 public:
  std::size_t count() const { return count_; }

 private:
  std::streamsize xsputn(const char*, std::streamsize size) override {
    count_ += static_cast<std::size_t>(size);
    return size;
  }

  std::size_t count_ = 0;
};

/// Appends what is written to it to `content`.
class AppendingBuffer : public std::streambuf {
 public:
  explicit AppendingBuffer(PagedVector<char>& content) : content_(content) {}

 private:
  std::streamsize xsputn(const char* bytes, std::streamsize size) override {
    append_paged(std::span(bytes, static_cast<std::size_t>(size)), content_);
    return size;
  }

  PagedVector<char>& content_;
};

/// The size is counted first: to let the content grow copies hundreds of megabytes several times.
template <typename Value>
PagedVector<char> encode_unit(const Value& value) {
  const auto write_to = [&](std::streambuf& buffer) {
    std::ostream stream(&buffer);
    cereal::BinaryOutputArchive archive(stream);
    archive(value);
  };
  CountingBuffer counting;
  write_to(counting);
  PagedVector<char> content;
  content.reserve(counting.count());
  AppendingBuffer appending(content);
  write_to(appending);
  return content;
}

/// Keeps what encode_unit() makes of a value.
template <typename Value>
void keep_unit(UnitStore& store, const UnitKey& key, const Value& value) {
  const PagedVector<char> content = encode_unit(value);
  store.keep(key, {content.data(), content.size()});
}

/// Nothing unless `content` is what encode_unit() made of such a value.
template <typename Value>
std::optional<Value> decode_unit(std::string content) {
  std::istringstream stream(std::move(content), std::ios::binary);
  try {
    cereal::BinaryInputArchive archive(stream);
    Value value;
    archive(value);
    if (stream.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
    return value;
  } catch (const std::exception&) {  // Of cereal, or too large for the memory.
    return std::nullopt;
  }
}

}  // namespace relief
