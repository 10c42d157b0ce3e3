#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace relief {

/// Orders names as people count: runs of digits by their value (`2.png` before `10.png`). A strict
/// order of all names: `1.png` and `01.png` differ.
bool natural_less(std::string_view a, std::string_view b);

/// natural_less as the order of a map.
struct NaturalOrder {
  bool operator()(std::string_view a, std::string_view b) const { return natural_less(a, b); }
};

/// Puts paths into the natural order of their whole text.
void sort_naturally(std::vector<std::filesystem::path>& paths);

/// Whether there is a file at a path; no for what cannot be looked at.
bool is_file(const std::filesystem::path& path);

/// Whether a name begins with a point: what systems keep beside the user's files (`._1.png`).
bool is_hidden(const std::filesystem::path& path);

/// The files of a folder in natural order, without hidden ones; none where it cannot be listed.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

/// The folders in a folder, likewise.
std::vector<std::filesystem::path> folders_in(const std::filesystem::path& folder);

}  // namespace relief
