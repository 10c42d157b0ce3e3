#include "scan/base/system/system_memory.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include <unistd.h>

#include "scan/base/system/control_groups.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

std::size_t page_size() { return static_cast<std::size_t>(::sysconf(_SC_PAGE_SIZE)); }

std::size_t pages(int name) {
  return static_cast<std::size_t>(std::max(0l, ::sysconf(name))) * page_size();
}

struct Pages {
  std::size_t resident = 0, of_files = 0;  // Of which.
};

Pages pages_now() {
  unsigned long total = 0, resident = 0, of_files = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu %lu %lu", &total, &resident, &of_files) != 3)
      resident = of_files = 0;
    std::fclose(file);
  }
  return {resident, of_files};
}

std::size_t of_machine(const fs::path& root, std::string_view key, int name) {
  const auto kilobytes = number_after(root / "proc/meminfo", key);
  return kilobytes ? *kilobytes * 1024 : pages(name);
}

}  // namespace

std::size_t usable_memory(const fs::path& root) {
  return std::min(of_machine(root, "MemTotal:", _SC_PHYS_PAGES), limit_of_groups(root));
}

std::size_t free_memory(const fs::path& root) {
  return std::min(of_machine(root, "MemAvailable:", _SC_AVPHYS_PAGES), free_in_groups(root));
}

std::size_t resident_memory() { return pages_now().resident * page_size(); }

std::size_t anonymous_memory() {
  const Pages now = pages_now();
  return (now.resident - std::min(now.resident, now.of_files)) * page_size();
}

}  // namespace relief
