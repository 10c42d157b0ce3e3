#include "reconstruction/memory_check.h"

#include <algorithm>
#include <string>

#include "hybrid/mesh/mesh_preconditioner.h"
#include "hybrid/refine_memory.h"
#include "relief/hybrid/refine_view.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::reconstruction {

namespace {

constexpr int kMebibyteBits = 20;

Result<void> compare(const std::string& work, std::size_t needed, const MemoryLimit& limit,
                     const std::string& remedy) {
  if (needed <= limit.bytes()) return {};
  const auto mebibytes = [](std::size_t bytes) {
    return std::to_string((bytes >> kMebibyteBits) + 1) + " MiB";
  };
  return Error{ErrorKind::kUnsolvable,
               work + " needs about " + mebibytes(needed) + ", more than the memory limit of " +
                   std::to_string(limit.bytes() >> kMebibyteBits) + " MiB: " + remedy};
}

}  // namespace

Result<void> check_memory_to_refine(const std::vector<RangeView>& views,
                                    const hybrid::RefineOptions& options) {
  const MemoryLimit* const limit = current_memory_limit();
  if (!limit) return {};
  std::size_t largest = 0;
  for (const RangeView& view : views) {
    if (view.has_normals())
      largest = std::max(largest, hybrid::memory_to_refine(view, options.solver));
  }
  const std::size_t refining = largest > 0 ? largest + limit->most_in_memory() : 0;
  return compare("aligning and refining the views", resident_beyond_files() + refining, *limit,
                 "raise the limit, or give fewer views");
}

Result<void> check_memory_to_polish(std::size_t vertices) {
  const MemoryLimit* const limit = current_memory_limit();
  if (!limit) return {};
  return compare("polishing",
                 resident_beyond_files() + hybrid::MeshPreconditioner::memory(vertices), *limit,
                 "raise the limit, or merge without polishing (--no-polish)");
}

}  // namespace relief::reconstruction
