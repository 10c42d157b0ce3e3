#include "scan/base/memory/file_pieces.h"

#include <cassert>
#include <cstring>
#include <iterator>

namespace relief {

void* FilePieces::take(std::size_t bytes) {
  assert(bytes > 0 && bytes <= kLargest);
  const std::size_t size = kPage * pages_of(bytes);
  SameSize& pieces = of_pages_[pages_of(bytes)];
  if (!pieces.free.empty()) {
    void* const piece = pieces.free.back();
    pieces.free.pop_back();
    return std::memset(piece, 0, size);
  }
  if (pieces.left == 0) {
    const std::size_t whole = size * kPiecesOfFile;
    pieces.next = static_cast<char*>(map_(whole));
    if (!pieces.next) return nullptr;
    pieces.left = kPiecesOfFile;
    files_.emplace(pieces.next, whole);
  }
  char* const piece = pieces.next;
  pieces.next += size;
  --pieces.left;
  return piece;
}

bool FilePieces::give_back(void* address, std::size_t bytes) {
  const char* const piece = static_cast<const char*>(address);
  const auto after = files_.upper_bound(piece);
  if (after == files_.begin()) return false;
  const auto& [begin, size] = *std::prev(after);
  if (piece >= begin + size) return false;
  of_pages_[pages_of(bytes)].free.push_back(address);
  return true;
}

}  // namespace relief
