#include "relief/scan/page_allocator.h"

#include <new>

#include "scan/base/memory/memory_limit.h"

namespace relief {

void* allocate_pages(MemoryLimit* limit, std::size_t bytes) {
  return limit ? limit->allocate(bytes) : ::operator new(bytes);
}

void free_pages(MemoryLimit* limit, void* address, std::size_t bytes) {
  if (limit)
    limit->deallocate(address, bytes);
  else
    ::operator delete(address, bytes);
}

std::shared_ptr<MemoryLimit> shared_memory_limit() {
  MemoryLimit* const limit = current_memory_limit();
  return limit ? limit->shared_from_this() : nullptr;
}

}  // namespace relief
