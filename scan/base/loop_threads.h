#pragma once

#include <cstddef>
#include <functional>

namespace relief {

/// The threads under parallel.h: those of TBB, or plain ones where the thread sanitizer watches,
/// which sees no synchronisation inside of TBB.

/// How many threads a loop takes here.
int available_threads();

/// Calls `work` with so many threads available.
void with_available_threads(int threads, const std::function<void()>& work);

/// Calls `visit(i)` for each i below `count` on the threads available here, the caller among them.
/// An exception of `visit` is rethrown after all threads have stopped.
void visit_on_threads(std::size_t count, const std::function<void(std::size_t i)>& visit);

}  // namespace relief
