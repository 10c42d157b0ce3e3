#include "scan/io/e57/e57_pages.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "scan/io/files/io_error.h"

namespace relief {

namespace {

constexpr std::uint64_t kWindowPages = 256;  // read at once, a quarter of a megabyte

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

// Table k advances the checksum of a byte over k further bytes that are zero.
constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1u ? 0x82f63b78u : 0u);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < 8; ++k)
    for (std::size_t byte = 0; byte < 256; ++byte)
      tables[k][byte] = (tables[k - 1][byte] >> 8) ^ tables[0][tables[k - 1][byte] & 255u];
  return tables;
}
constexpr CrcTables kCrcTables = make_crc_tables();

std::uint32_t big_endian_at(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

void append_page(std::string& pages, std::string_view payload) {
  std::string page(payload);
  page.resize(kE57PayloadBytes, '\0');
  const std::uint32_t crc = crc32c(page);
  for (int shift = 24; shift >= 0; shift -= 8) page += static_cast<char>(crc >> shift & 255u);
  pages += page;
}

}  // namespace

// Eight bytes a step ("slicing by eight", Kounavis and Berry 2005).
std::uint32_t crc32c(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    const std::uint64_t eight = e57_number_at<std::uint64_t>(bytes.data()) ^ crc;
    crc = 0;
    for (std::size_t k = 0; k < 8; ++k) crc ^= kCrcTables[7 - k][eight >> (8 * k) & 255u];
  }
  for (const char c : bytes)
    crc = (crc >> 8) ^ kCrcTables[0][(crc ^ static_cast<unsigned char>(c)) & 255u];
  return ~crc;
}

std::string e57_pages_from(std::string_view payload) {
  std::string pages;
  pages.reserve((payload.size() / kE57PayloadBytes + 1) * kE57PageBytes);
  for (std::size_t at = 0; at < payload.size(); at += kE57PayloadBytes)
    append_page(pages, payload.substr(at, kE57PayloadBytes));
  return pages;
}

Result<E57Pages> E57Pages::open(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return bad_input(path, "no such file");
  const std::uint64_t bytes = std::filesystem::file_size(path, code);
  E57Pages pages(path, code ? 0 : bytes);
  pages.file_.open(path, std::ios::binary);
  if (!pages.file_) return bad_input(path, "cannot be read");
  if (auto header = pages.check_header(); !header) return header.error();
  return pages;
}

Result<E57Pages> E57Pages::in_memory(std::string_view content, const std::filesystem::path& path) {
  E57Pages pages(path, content.size());
  pages.memory_ = content;
  pages.from_memory_ = true;
  if (auto header = pages.check_header(); !header) return header.error();
  return pages;
}

Result<void> E57Pages::check_header() {
  if (file_bytes_ < kE57PageBytes)
    return bad_input(path_, "truncated E57: it has " + std::to_string(file_bytes_) +
                                " bytes, less than a page of " + std::to_string(kE57PageBytes));
  // The signature first, so that a file of another format is not called damaged.
  fetch(0, kE57PageBytes);
  if (!window_.starts_with("ASTM-E57"))
    return bad_input(path_, "not an E57 file: its first 8 bytes are not 'ASTM-E57'");
  window_.clear();
  const auto header = read(0, kE57HeaderBytes, "the header");
  if (!header) return header.error();
  return check_numbers(header->data());
}

Result<void> E57Pages::check_numbers(const char* header) {
  const auto version = e57_number_at<std::uint32_t>(header + 8);
  const auto file_bytes = e57_number_at<std::uint64_t>(header + 16);
  const auto page_bytes = e57_number_at<std::uint64_t>(header + 40);
  xml_offset_ = e57_number_at<std::uint64_t>(header + 24);
  xml_bytes_ = e57_number_at<std::uint64_t>(header + 32);
  if (version != 1)
    return bad_input(path_, "byte 8 of the E57 header: version " + std::to_string(version) +
                                " of the format, but only version 1 is known");
  if (page_bytes != kE57PageBytes)
    return bad_input(path_, "byte 40 of the E57 header: pages of " + std::to_string(page_bytes) +
                                " bytes, but the standard has " + std::to_string(kE57PageBytes));
  if (file_bytes != file_bytes_ || file_bytes_ % kE57PageBytes != 0)
    return bad_input(path_, "truncated or damaged E57: it has " + std::to_string(file_bytes_) +
                                " bytes, but byte 16 of its header promises " +
                                std::to_string(file_bytes) + "; copy it again");
  return {};
}

Result<std::uint64_t> E57Pages::logical_offset(std::uint64_t physical,
                                               const std::string& what) const {
  const std::uint64_t in_page = physical % kE57PageBytes;
  if (physical >= file_bytes_ || in_page >= kE57PayloadBytes)
    return bad_input(path_, "damaged E57: " + what + " would be at byte " +
                                std::to_string(physical) +
                                (physical >= file_bytes_ ? ", past the end of the file"
                                                         : ", within the checksum of a page"));
  return physical / kE57PageBytes * kE57PayloadBytes + in_page;
}

Result<std::string_view> E57Pages::read(std::uint64_t logical, std::uint64_t length,
                                        const std::string& what) {
  if (logical > payload_bytes() || length > payload_bytes() - logical)
    return bad_input(path_, "damaged E57: " + what + " at byte " +
                                std::to_string(e57_physical(logical)) + " would have " +
                                std::to_string(length) + " bytes, more than the file has left");
  const bool at_hand =
      logical >= window_begin_ && logical + length <= window_begin_ + window_.size();
  if (!at_hand) {
    const std::uint64_t first = logical / kE57PayloadBytes;
    const std::uint64_t needed = (logical + length + kE57PayloadBytes - 1) / kE57PayloadBytes;
    if (auto loaded = load(first, needed - first); !loaded) {
      Error error = loaded.error();
      error.message += " (needed for " + what + ")";
      return error;
    }
  }
  return std::string_view(window_).substr(logical - window_begin_, length);
}

// Reads ahead, but a page that is only read ahead may be damaged.
Result<void> E57Pages::load(std::uint64_t first_page, std::uint64_t pages) {
  const std::uint64_t all = file_bytes_ / kE57PageBytes;
  const std::uint64_t ahead = std::min(all - first_page, std::max(pages, kWindowPages));
  if (pages < ahead && unpack(first_page, ahead).ok()) return {};
  return unpack(first_page, pages);
}

// The bytes of some pages as they stand in the file; fewer where it ends.
void E57Pages::fetch(std::uint64_t begin, std::uint64_t bytes) {
  if (from_memory_) {
    window_.assign(memory_.substr(begin, bytes));
    return;
  }
  window_.resize(bytes);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(begin));
  file_.read(window_.data(), static_cast<std::streamsize>(bytes));
  window_.resize(static_cast<std::size_t>(file_.gcount()));
}

Result<void> E57Pages::unpack(std::uint64_t first_page, std::uint64_t pages) {
  window_begin_ = first_page * kE57PayloadBytes;
  fetch(first_page * kE57PageBytes, pages * kE57PageBytes);
  for (std::uint64_t page = 0; page < pages; ++page) {
    char* bytes = window_.data() + page * kE57PageBytes;
    const bool whole = (page + 1) * kE57PageBytes <= window_.size();
    if (!whole || crc32c({bytes, kE57PayloadBytes}) != big_endian_at(bytes + kE57PayloadBytes)) {
      window_.clear();
      return wrong_checksum(first_page + page);
    }
    std::memmove(window_.data() + page * kE57PayloadBytes, bytes, kE57PayloadBytes);
  }
  window_.resize(pages * kE57PayloadBytes);
  return {};
}

Error E57Pages::wrong_checksum(std::uint64_t page) const {
  return bad_input(path_, "damaged E57: the checksum of page " + std::to_string(page) +
                              " (from byte " + std::to_string(page * kE57PageBytes) +
                              ") does not match its content; copy the file again or export it "
                              "anew");
}

}  // namespace relief
