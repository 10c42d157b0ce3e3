#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "relief/scan/result.h"

namespace relief {

/// A file of the standard ASTM E2807 is a row of pages: 1020 bytes of payload, then the CRC-32C of
/// these, most significant byte first. Offsets in the file count all bytes (physical); lengths
/// count payload alone (logical).
inline constexpr std::uint64_t kE57PageBytes = 1024;
inline constexpr std::uint64_t kE57PayloadBytes = 1020;
inline constexpr std::uint64_t kE57HeaderBytes = 48;

/// A number as these files hold it, least significant byte first.
template <typename T>
T e57_number_at(const char* bytes) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// The CRC-32C (Castagnoli, reflected polynomial 82f63b78) of some bytes.
std::uint32_t crc32c(std::string_view bytes);

/// Cuts a payload into pages, the last one filled up with zeros, and adds the checksums.
std::string e57_pages_from(std::string_view payload);

/// The physical offset of a place in the payload.
constexpr std::uint64_t e57_physical(std::uint64_t logical) {
  return logical / kE57PayloadBytes * kE57PageBytes + logical % kE57PayloadBytes;
}

/// The payload of a file, from the disk or from memory. Only the pages that are asked for are read,
/// and the checksum of each of them is checked.
class E57Pages {
 public:
  /// kBadInput when there is no such file or its header contradicts the standard or the size.
  static Result<E57Pages> open(const std::filesystem::path& path);
  /// The same for content in memory that outlives the result; `path` is for messages.
  static Result<E57Pages> in_memory(std::string_view content, const std::filesystem::path& path);

  /// `length` bytes of payload from a logical offset, valid to the next call. kBadInput names
  /// `what`, the page and the byte when the file ends before or a checksum is wrong.
  Result<std::string_view> read(std::uint64_t logical, std::uint64_t length,
                                const std::string& what);

  /// The logical offset of a physical one. kBadInput names `what` when it is outside of the file
  /// or within a checksum.
  Result<std::uint64_t> logical_offset(std::uint64_t physical, const std::string& what) const;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t file_bytes() const { return file_bytes_; }
  std::uint64_t payload_bytes() const { return file_bytes_ / kE57PageBytes * kE57PayloadBytes; }
  std::uint64_t xml_offset() const { return xml_offset_; }  ///< Physical.
  std::uint64_t xml_bytes() const { return xml_bytes_; }    ///< Logical.

 private:
  E57Pages(std::filesystem::path path, std::uint64_t file_bytes)
      : path_(std::move(path)), file_bytes_(file_bytes) {}

  Result<void> check_header();
  Result<void> check_numbers(const char* header);
  Result<void> load(std::uint64_t first_page, std::uint64_t pages);
  void fetch(std::uint64_t begin, std::uint64_t bytes);
  Error wrong_checksum(std::uint64_t page) const;
  Result<void> unpack(std::uint64_t first_page, std::uint64_t pages);

  std::filesystem::path path_;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t xml_offset_ = 0, xml_bytes_ = 0;
  std::string_view memory_;
  std::ifstream file_;
  bool from_memory_ = false;
  std::string window_;              // payload of the pages that were read last
  std::uint64_t window_begin_ = 0;  // its logical offset
};

}  // namespace relief
