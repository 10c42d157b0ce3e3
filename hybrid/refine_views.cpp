#include "hybrid/refine_views.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>

#include "scan/parallel.h"

namespace relief {

Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options,
                                              const Progress& progress) {
  const int threads = thread_count(options.threads);
  const int at_once = std::clamp(static_cast<int>(views.size()), 1, threads);
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
      results[i] = refine_view(views[i], view_options, tick);
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

}  // namespace relief
