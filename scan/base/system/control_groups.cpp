#include "scan/base/system/control_groups.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "scan/base/system/system_memory.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Nothing where there is no such file; `max` means no limit.
std::optional<std::size_t> number_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  if (!(stream >> word)) return std::nullopt;
  if (word == "max") return kUnlimited;
  std::size_t value = 0;
  return std::istringstream(word) >> value ? std::optional(value) : std::nullopt;
}

// How a version of control groups names things.
struct GroupVersion {
  const char* folder;  // Where its groups are mounted.
  const char *limit, *used;
  const char* reclaimable;  // Key in memory.stat of copies of files that can be dropped.
};
constexpr GroupVersion kVersion1{"sys/fs/cgroup/memory", "memory.limit_in_bytes",
                                 "memory.usage_in_bytes", "total_inactive_file"};
constexpr GroupVersion kVersion2{"sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"};

struct Group {
  GroupVersion version;
  fs::path folder;
};

// The group that a line of /proc/self/cgroup names, `ID:CONTROLLERS:PATH`, and all around it.
// Inside a container its own groups may be all that is mounted: then only the outermost folder of
// these exists.
void add_groups(const GroupVersion& version, const fs::path& root, const std::string& path,
                std::vector<Group>& groups) {
  const fs::path top = root / version.folder;
  for (fs::path inner = fs::path(path).relative_path(); !inner.empty(); inner = inner.parent_path())
    groups.push_back({version, top / inner});
  groups.push_back({version, top});
}

std::vector<Group> groups_of_process(const fs::path& root) {
  std::vector<Group> groups;
  std::ifstream stream(root / "proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::string path = line.substr(second + 1);
    if (controllers == ",,") add_groups(kVersion2, root, path, groups);
    if (controllers.find(",memory,") != std::string::npos)
      add_groups(kVersion1, root, path, groups);
  }
  return groups;
}

std::size_t free_in(const Group& group) {
  const auto limit = number_in(group.folder / group.version.limit);
  const auto used = number_in(group.folder / group.version.used);
  if (!limit || !used || *limit == kUnlimited) return kUnlimited;
  const std::size_t reclaimable =
      number_after(group.folder / "memory.stat", group.version.reclaimable).value_or(0);
  const std::size_t needed = *used - std::min(*used, reclaimable);
  return *limit - std::min(*limit, needed);
}

// The least of what `number` tells of the groups of this process.
template <typename Number>
std::size_t least_of_groups(const fs::path& root, const Number& number) {
  std::size_t least = kUnlimited;
  for (const Group& group : groups_of_process(root)) least = std::min(least, number(group));
  return least;
}

}  // namespace

std::optional<std::size_t> number_after(const fs::path& file, std::string_view key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string name;
    std::size_t value = 0;
    if (words >> name >> value && name == key) return value;
  }
  return std::nullopt;
}

std::size_t limit_of_groups(const fs::path& root) {
  return least_of_groups(root, [](const Group& group) {
    return number_in(group.folder / group.version.limit).value_or(kUnlimited);
  });
}

std::size_t free_in_groups(const fs::path& root) { return least_of_groups(root, free_in); }

std::size_t memory_in_groups(const fs::path& root) {
  const bool limited = limit_of_groups(root) <= usable_memory(root);
  return limited ? resident_memory() + free_in_groups(root) : 0;
}

}  // namespace relief
