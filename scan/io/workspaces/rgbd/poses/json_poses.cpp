#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool are_numbers(const json& values, std::size_t count) {
  return values.is_array() && values.size() == count &&
         std::ranges::all_of(values, [](const json& value) { return value.is_number(); });
}

// The numbers of a matrix by rows; empty for what is none.
std::vector<double> matrix_numbers(const json& value) {
  if (are_numbers(value, 12) || are_numbers(value, 16)) return value.get<std::vector<double>>();
  std::vector<double> numbers;
  if (!value.is_array() || (value.size() != 3 && value.size() != 4)) return numbers;
  for (const json& row : value) {
    if (!are_numbers(row, 4)) return {};
    for (const json& number : row) numbers.push_back(number.get<double>());
  }
  return numbers;
}

// The only matrix of an entry; empty where it has none or several.
std::vector<double> only_matrix_in(const json& entry) {
  std::vector<double> found;
  for (const json& value : entry) {
    auto numbers = matrix_numbers(value);
    if (numbers.empty()) continue;
    if (!found.empty()) return {};
    found = std::move(numbers);
  }
  return found;
}

// The texts and whole numbers of an entry, by their keys.
std::map<std::string, std::string> texts_in(const json& entry) {
  std::map<std::string, std::string> texts;
  for (const auto& [key, value] : entry.items()) {
    if (value.is_string()) texts[key] = value.get<std::string>();
    if (value.is_number_integer()) texts[key] = value.dump();
  }
  return texts;
}

// An entry that has a matrix.
struct PoseEntry {
  std::string key;
  std::vector<double> matrix;
  std::map<std::string, std::string> texts;
};

std::vector<PoseEntry> entries_in(const json& container) {
  std::vector<PoseEntry> entries;
  if (!container.is_structured() || !matrix_numbers(container).empty()) return entries;
  for (const auto& [key, value] : container.items()) {
    PoseEntry entry{key, matrix_numbers(value), {}};
    if (entry.matrix.empty() && value.is_object()) {
      entry.matrix = only_matrix_in(value);
      entry.texts = texts_in(value);
    }
    if (!entry.matrix.empty()) entries.push_back(std::move(entry));
  }
  return entries;
}

// The texts that all entries have under the same key.
void take_names(const std::vector<PoseEntry>& entries, PoseList& poses) {
  for (const auto& [key, text] : entries.front().texts) {
    std::vector<std::string> names;
    for (const PoseEntry& entry : entries)
      if (const auto found = entry.texts.find(key); found != entry.texts.end())
        names.push_back(found->second);
    if (names.size() == entries.size()) poses.names[key] = std::move(names);
  }
}

}  // namespace

Result<PoseList> parse_json_poses(std::string_view text, const fs::path& path) {
  const json document = json::parse(without_byte_order_mark(text), nullptr, false);
  PoseList poses;
  if (!document.is_structured()) return poses;
  const json* container = &document;
  auto entries = entries_in(document);
  std::string place;
  for (const auto& [key, part] : document.items()) {
    auto inner = entries_in(part);
    const bool is_wrapper = document.is_object() && inner.size() == 1;  // {"poses": {"a": ...}}
    if (inner.size() < entries.size() + (is_wrapper ? 0 : 1)) continue;
    entries = std::move(inner);
    container = &part;
    place = key + ".";
  }
  if (entries.empty()) return poses;
  for (const PoseEntry& entry : entries) {
    const auto motion = motion_of_numbers(entry.matrix, "the matrix of " + place + entry.key);
    if (!motion) return bad_input(path, motion.error().message);
    poses.world_from_view.push_back(*motion);
    if (container->is_object()) poses.names[""].push_back(entry.key);
  }
  take_names(entries, poses);
  poses.is_ordered = container->is_array() && poses.names.empty();
  return poses;
}

}  // namespace relief
