// Any bytes as a PTX file: a value or an error, never a crash or a huge allocation.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "scan/io/clouds/files/ptx_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  const auto scans = relief::list_ptx_scans(content, "fuzz.ptx");
  for (int scan = 0; scan < (scans.ok() ? static_cast<int>(scans->size()) : 1); ++scan) {
    (void)relief::parse_ptx_scan(content, "fuzz.ptx", scan);
    (void)relief::parse_ptx_scan(content, "fuzz.ptx", scan, relief::PtxMatrix::kApply);
  }
  return 0;
}
