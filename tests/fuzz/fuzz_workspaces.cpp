// libFuzzer target over the parsers of other programs' projects that work in memory. The first byte
// selects the parser, the rest is the file.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "tests/fuzz/workspace_parsers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using relief::testing::kWorkspaceParsers;
  if (size == 0) return 0;
  const std::string_view content(reinterpret_cast<const char*>(data) + 1, size - 1);
  kWorkspaceParsers[data[0] % kWorkspaceParsers.size()].parse(content);
  (void)relief::kind_of_rgbd_text(content);
  return 0;
}
