#include "reconstruction/memory_check.h"

#include <algorithm>
#include <string>

#include "hybrid/refine_memory.h"
#include "relief/hybrid/refine_view.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::reconstruction {

namespace {

constexpr int kMebibyteBits = 20;

// Measured on the bear, the bunny and five views of a Kinect (docs/results.md).
constexpr std::size_t kAlignedPixel = 8;      // Samples for alignment [bytes per pixel].
constexpr std::size_t kPolishedVertex = 320;  // Mesh, its graph and the system [bytes per vertex].

Result<void> compare(const std::string& work, std::size_t needed, std::size_t limit,
                     const std::string& remedy) {
  if (limit == 0 || needed <= limit) return {};
  const auto mebibytes = [](std::size_t bytes) {
    return std::to_string((bytes >> kMebibyteBits) + 1) + " MiB";
  };
  return Error{ErrorKind::kUnsolvable,
               work + " needs about " + mebibytes(needed) + ", more than the memory limit of " +
                   std::to_string(limit >> kMebibyteBits) + " MiB: " + remedy};
}

}  // namespace

Result<void> check_memory_to_refine(const std::vector<RangeView>& views,
                                    const hybrid::RefineOptions& options, std::size_t limit) {
  if (limit == 0) return {};
  std::size_t pixels = 0, largest = 0;
  for (const RangeView& view : views) {
    pixels += view.range.size();
    if (view.has_normals())
      largest = std::max(largest, hybrid::memory_to_refine(view, options.solver));
  }
  const std::size_t refining = largest > 0 ? largest + MemoryLimit::most_of_grids(limit) : 0;
  return compare("aligning and refining the views",
                 resident_beyond_files() + std::max(kAlignedPixel * pixels, refining), limit,
                 "raise the limit, or give fewer views");
}

Result<void> check_memory_to_polish(std::size_t vertices, std::size_t limit) {
  return compare("polishing", kPolishedVertex * vertices, limit,
                 "raise the limit, or merge without polishing (--no-polish)");
}

}  // namespace relief::reconstruction
