#include "relief/hybrid/refine_views.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>

#include "scan/base/parallel.h"
#include "scan/base/system_memory.h"

namespace relief::hybrid {

namespace {

// Peak memory of refine_view per pixel of the grid [bytes], beyond its input: measured on full
// grids, see docs/results.md.
std::size_t bytes_per_pixel(Solver solver) { return solver == Solver::kMultigrid ? 400 : 3000; }

}  // namespace

int views_at_once(const std::vector<RangeView>& views, const RefineOptions& options,
                  std::size_t memory) {
  const std::size_t budget = memory > 0 ? memory : usable_memory() / 2;
  std::vector<std::size_t> needs;
  for (const RangeView& view : views)
    needs.push_back(view.range.size() * bytes_per_pixel(options.solver));
  std::sort(needs.begin(), needs.end(), std::greater<>());
  const std::size_t most =
      std::min(needs.size(), static_cast<std::size_t>(thread_count(options.threads)));
  std::size_t count = 0, used = 0;
  while (count < most && used + needs[count] <= budget) used += needs[count++];
  return std::max(1, static_cast<int>(count));
}

Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options,
                                              const Progress& progress, std::size_t memory,
                                              const RefineOne& refine) {
  const int threads = thread_count(options.threads);
  const int at_once = views_at_once(views, options, memory);
  RefineOptions view_options = options;
  view_options.threads = std::max(1, threads / at_once);

  std::vector<std::optional<Result<RefinedView>>> results(views.size());
  std::atomic<std::size_t> done{0};
  std::atomic<bool> stop{false};
  const auto caller = std::this_thread::get_id();
  // Only the caller's thread may report; the others stop when it was told to.
  const Progress tick = [&](double, std::string_view) {
    if (std::this_thread::get_id() == caller) {
      const double fraction = static_cast<double>(done) / static_cast<double>(views.size());
      if (!report_progress(progress, fraction, "solving for positions and normals")) stop = true;
    }
    return !stop;
  };
  parallel_for(views.size(), 1, at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && tick(0.0, {}); ++i) {
      results[i] = refine(views[i], view_options, tick);
      ++done;
    }
  });

  if (stop) return Error{ErrorKind::kInterrupted, "refinement was interrupted"};
  report_progress(progress, 1.0, "done");
  std::vector<RefinedView> refined;
  refined.reserve(views.size());
  for (auto& result : results) {
    if (!*result) return result->error();
    refined.push_back(std::move(*result).value());
  }
  return refined;
}

}  // namespace relief::hybrid
