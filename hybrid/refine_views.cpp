#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>

#include "hybrid/model/view_part.h"
#include "hybrid/refine_memory.h"
#include "relief/hybrid/refine_view.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/parallel.h"
#include "scan/base/system/system_memory.h"

namespace relief::hybrid {

namespace {

// Memory of refine_view beyond its input: per pixel of the part that is refined, and per sample
// [bytes]. Measured on full grids and on the masked ones of the bear, see docs/results.md.
constexpr std::size_t kPixel = 100;
std::size_t bytes_per_sample(Solver solver) { return solver == Solver::kMultigrid ? 300 : 2900; }

}  // namespace

std::size_t memory_to_refine(const RangeView& view, Solver solver) {
  return kPixel * part_to_refine(view).pixels() + bytes_per_sample(solver) * view.sample_count();
}

int views_at_once(const std::vector<RangeView>& views, const RefineOptions& options,
                  std::size_t memory) {
  const std::size_t budget = memory > 0 ? memory : usable_memory() / 2;
  std::vector<std::size_t> needs;
  for (const RangeView& view : views) needs.push_back(memory_to_refine(view, options.solver));
  std::sort(needs.begin(), needs.end(), std::greater<>());
  const std::size_t most = std::min(needs.size(), static_cast<std::size_t>(thread_count()));
  std::size_t count = 0, used = 0;
  while (count < most && used + needs[count] <= budget) used += needs[count++];
  return std::max(1, static_cast<int>(count));
}

namespace {

// What the memory limit leaves for refining, at least one byte; 0: there is none. Refined views lie
// in files, but for what the limit lets grids have in memory.
std::size_t memory_left() {
  const MemoryLimit* const limit = current_memory_limit();
  if (!limit) return 0;
  const std::size_t taken = resident_beyond_files() + limit->most_in_memory();
  return std::max(limit->bytes(), taken + 1) - taken;
}

// Some views at a time, each on its part of the threads.
std::vector<std::optional<Result<RefinedView>>> refine_some_at_once(
    const std::vector<RangeView>& views, const RefineOptions& options, const Context& context,
    const RefineOne& refine) {
  const int at_once = views_at_once(views, options, memory_left());
  Context of_view = context;
  of_view.threads = std::max(1, thread_count() / at_once);
  std::vector<std::optional<Result<RefinedView>>> results(views.size());
  std::atomic<std::size_t> done{0};
  std::atomic<bool> stop{false};
  const auto caller = std::this_thread::get_id();
  // Only the caller's thread may report; the others stop when it was told to.
  of_view.progress = [&](double, std::string_view) {
    if (std::this_thread::get_id() == caller) {
      const double fraction = static_cast<double>(done) / static_cast<double>(views.size());
      if (!report_progress(context.progress, fraction, "solving for positions and normals"))
        stop = true;
    }
    return !stop;
  };
  on_threads(at_once, [&] {
    parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && of_view.progress(0.0, {}); ++i) {
        results[i] = refine(views[i], options, of_view);
        ++done;
      }
    });
  });
  return results;
}

}  // namespace

Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options, const Context& context,
                                              const RefineOne& refine) {
  return run_in(context, [&]() -> Result<std::vector<RefinedView>> {
    auto results = refine_some_at_once(views, options, context, refine);
    std::vector<RefinedView> refined;
    refined.reserve(views.size());
    for (auto& result : results) {
      if (!result) return Error{ErrorKind::kInterrupted, "refinement was interrupted"};
      if (!*result) return result->error();
      refined.push_back(std::move(*result).value());
    }
    report_progress(context.progress, 1.0, "done");
    return refined;
  });
}

}  // namespace relief::hybrid
