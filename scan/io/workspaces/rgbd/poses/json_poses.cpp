#include <algorithm>
#include <optional>
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

// The frame that an entry of a list names: its first text, or else its first whole number.
std::string frame_named_in(const json& entry) {
  for (const json& value : entry)
    if (value.is_string()) return value.get<std::string>();
  for (const json& value : entry)
    if (value.is_number_integer()) return value.dump();
  return {};
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

class JsonPoses {
 public:
  explicit JsonPoses(const fs::path& path) : path_(path) {}

  Result<NamedPoses> of(const json& document) {
    if (!document.is_structured()) return NamedPoses();
    const auto is_part = [](const json& value) {
      return value.is_structured() && matrix_numbers(value).empty() && value.size() > 0;
    };
    const bool wrapped = document.is_object() && std::ranges::count_if(document, is_part) == 1;
    if (!wrapped)
      if (auto taken = take(document, ""); !taken) return taken.error();
    for (const auto& [key, part] : document.items()) {
      if (!poses_.empty()) break;
      if (auto taken = take(part, key + "."); !taken) return taken.error();
    }
    if (poses_.empty() && wrapped)
      if (auto taken = take(document, ""); !taken) return taken.error();
    return std::move(poses_);
  }

 private:
  Result<void> take(const json& entries, const std::string& place) {
    if (!matrix_numbers(entries).empty() || !entries.is_structured()) return {};
    for (const auto& [key, entry] : entries.items()) {
      auto numbers = matrix_numbers(entry);
      std::string frame = entries.is_object() ? key : "";
      if (numbers.empty() && entry.is_object()) {
        numbers = only_matrix_in(entry);
        if (entries.is_array()) frame = frame_named_in(entry);
      }
      if (numbers.empty()) continue;
      const auto motion = motion_of_numbers(numbers, "the matrix of " + place + key);
      if (!motion) return bad_input(path_, motion.error().message);
      poses_.push_back({std::move(frame), *motion});
    }
    return {};
  }

  const fs::path& path_;
  NamedPoses poses_;
};

}  // namespace

Result<NamedPoses> parse_json_poses(std::string_view text, const fs::path& path) {
  const json document = json::parse(without_byte_order_mark(text), nullptr, false);
  if (document.is_discarded()) return NamedPoses();
  return JsonPoses(path).of(document);
}

}  // namespace relief
