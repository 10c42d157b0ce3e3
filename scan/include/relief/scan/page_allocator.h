#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace relief {

class MemoryLimit;

/// `bytes` of memory, aligned for any type: on the heap, or, where `limit` is not null and not
/// ample for them, in a temporary file that is mapped to memory. Throws std::bad_alloc.
void* allocate_pages(MemoryLimit* limit, std::size_t bytes);
void free_pages(MemoryLimit* limit, void* address, std::size_t bytes);

/// The limit of the enclosing run_in(); null: there is none.
std::shared_ptr<MemoryLimit> shared_memory_limit();

/// Allocates the pixels of a Grid, and other large arrays. Under the memory limit of a context
/// (Context::memory) large ones lie in temporary files, so the system can take their pages back
/// while nobody reads them. Where numbers lie changes none of them.
template <typename T>
class PageAllocator {
 public:
  using value_type = T;
  using propagate_on_container_move_assignment = std::true_type;
  using propagate_on_container_swap = std::true_type;

  PageAllocator() : limit_(shared_memory_limit()) {}
  template <typename U>
  explicit PageAllocator(const PageAllocator<U>& other) : limit_(other.limit()) {}

  T* allocate(std::size_t count) {
    return static_cast<T*>(allocate_pages(limit_.get(), count * sizeof(T)));
  }
  void deallocate(T* address, std::size_t count) {
    free_pages(limit_.get(), address, count * sizeof(T));
  }
  /// Copies heed the limit where they are made.
  PageAllocator select_on_container_copy_construction() const { return {}; }

  const std::shared_ptr<MemoryLimit>& limit() const { return limit_; }
  template <typename U>
  bool operator==(const PageAllocator<U>& other) const {
    return limit_ == other.limit();
  }

 private:
  std::shared_ptr<MemoryLimit> limit_;
};

/// A vector whose values lie as those of a Grid do.
template <typename T>
using PagedVector = std::vector<T, PageAllocator<T>>;

}  // namespace relief
