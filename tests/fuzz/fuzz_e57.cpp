// libFuzzer target of the E57 reader. Each input is read as it is, and again with right checksums
// and the right length in its header, which a fuzzer would hardly find.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "scan/io/e57/e57_file.h"
#include "scan/io/e57/e57_pages.h"
#include "scan/io/files/binary_writer.h"

namespace {

void read_all(std::string_view content) {
  const auto scans = relief::parse_e57_scans(content, "fuzz.e57");
  if (!scans) return;
  // Many scans may share one section: a few of them tell as much.
  for (std::size_t scan = 0; scan < scans->size() && scan < 3; ++scan)
    (void)relief::parse_e57_scan(content, "fuzz.e57", static_cast<int>(scan));
}

std::string repaired(std::string_view content) {
  std::string payload;
  for (std::size_t at = 0; at < content.size(); at += relief::kE57PageBytes)
    payload += content.substr(at, relief::kE57PayloadBytes);
  payload.resize(std::max<std::size_t>(payload.size(), relief::kE57HeaderBytes));
  std::string length;
  const std::size_t pages =
      (payload.size() + relief::kE57PayloadBytes - 1) / relief::kE57PayloadBytes;
  relief::append_little_endian(length, static_cast<std::uint64_t>(pages * relief::kE57PageBytes));
  payload.replace(16, length.size(), length);
  return relief::e57_pages_from(payload);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  read_all(content);
  read_all(repaired(content));
  return 0;
}
