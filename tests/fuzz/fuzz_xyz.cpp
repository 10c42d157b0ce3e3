// Any bytes as a text of points, and such points on a grid of rays: a value or an error, never a
// crash or a huge allocation.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "scan/io/clouds/cloud_grid.h"
#include "scan/io/clouds/files/point_cloud_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view content(reinterpret_cast<const char*>(data), size);
  auto cloud = relief::parse_xyz(content, "fuzz.xyz");
  if (cloud.ok()) (void)relief::grid_from_cloud(*std::move(cloud));
  return 0;
}
