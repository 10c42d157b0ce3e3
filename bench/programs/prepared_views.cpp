// How long it takes to prepare a view for alignment and for merging, against reading back from a
// folder of units what merging keeps of it: whether a view prepared should be a unit of work
// (docs/cache.md). Processor time of one thread; medians over the views of a project.
//   build/bench/bench/relief_prepared_views scans/scan.json
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "registration/surface/view_surface.h"
#include "relief/io/project_io.h"
#include "relief/reconstruction/unit_folder.h"
#include "relief/scan/context.h"
#include "scan/base/median.h"
#include "scan/units/input_hash.h"

namespace {

struct Seconds {
  std::vector<double> aligning, merging, hashing, reading;
};

template <typename Work>
void time(std::vector<double>& seconds, const Work& work) {
  const std::clock_t begin = std::clock();
  work();
  seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
}

// Bytes of no pattern, as many as merging keeps of the view.
std::string content_like(std::size_t bytes) {
  std::string content(bytes, '\0');
  std::uint32_t state = 1;
  for (char& byte : content) {
    state = 1664525u * state + 1013904223u;  // Numerical Recipes' linear congruential generator.
    byte = static_cast<char>(state >> 24);
  }
  return content;
}

bool measure(const relief::RangeView& view, relief::UnitStore& store, Seconds& seconds,
             std::vector<double>& megabytes) {
  std::optional<relief::registration::ViewSurface> aligned;
  time(seconds.aligning, [&] { aligned.emplace(view); });
  std::optional<relief::Result<relief::fusion::ViewSampler>> merged;
  time(seconds.merging, [&] { merged.emplace(relief::fusion::ViewSampler::create(view, {})); });
  if (!*merged) return false;
  const std::size_t bytes = (*merged)->bytes();
  std::string hash;
  time(seconds.hashing, [&] { hash = relief::hash_of_view(view); });
  const relief::UnitKey key{"prepared", hash};
  store.keep(key, content_like(bytes));
  std::optional<std::string> found;
  time(seconds.reading, [&] { found = store.find(key); });
  megabytes.push_back(1e-6 * static_cast<double>(bytes));
  return found.has_value();
}

int run(const char* project_file, const std::filesystem::path& folder) {
  const auto project = relief::read_project(project_file);
  if (!project) return std::puts(project.error().message.c_str()), 1;
  const auto units = relief::reconstruction::UnitFolder::open(folder);
  if (!units) return std::puts(units.error().message.c_str()), 1;
  Seconds seconds;
  std::vector<double> megabytes;
  for (const relief::RangeView& view : project->views)
    if (!measure(view, **units, seconds, megabytes)) return std::puts("a view failed"), 1;
  std::printf(
      "median of %zu views: aligning %.3f s, merging %.3f s; reading %.1f MB %.3f s, "
      "hashing the view for its key %.3f s\n",
      project->views.size(), relief::median(seconds.aligning), relief::median(seconds.merging),
      relief::median(megabytes), relief::median(seconds.reading), relief::median(seconds.hashing));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::puts("usage: relief_prepared_views PROJECT"), 2;
  const auto folder = std::filesystem::temp_directory_path() / "relief-prepared-views";
  const int status = relief::on_threads(1, [&] { return run(argv[1], folder); });
  std::filesystem::remove_all(folder);
  return status;
}
