#include "scan/io/workspaces/pose_beside.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Sixteen numbers take less; a larger text beside a scan is no matrix.
constexpr std::uintmax_t kMaxMatrixBytes = 4096;

// The matrix that CloudCompare saves after a registration; the date follows in its name.
Result<std::optional<fs::path>> registration_matrix(const fs::path& folder,
                                                    const std::string& stem) {
  std::error_code code;
  std::optional<fs::path> found;
  const fs::path listed = folder.empty() ? fs::path(".") : folder;
  for (const auto& entry : fs::directory_iterator(listed, code)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(stem + "_REGISTRATION_MATRIX") || !name.ends_with(".txt")) continue;
    const fs::path path = folder / name;
    if (found)
      return bad_input(std::max(path, *found), "is a second matrix of " + stem + ", beside " +
                                                   std::min(path, *found).filename().string() +
                                                   "; keep the one that holds");
    found = path;
  }
  return found;
}

bool holds_sixteen_numbers(std::string_view text) {
  std::size_t rows = 0;
  while (!text.empty()) {
    const std::string_view line = trimmed(next_line(text));
    double row[4];
    if (line.empty()) continue;
    if (!parse_row(line, 4, row)) return false;
    ++rows;
  }
  return rows == 4;
}

Result<std::optional<RigidMotion>> read_matrix_file(const fs::path& path, bool must_be_matrix) {
  std::error_code code;
  const bool small = fs::file_size(path, code) <= kMaxMatrixBytes && !code;
  if (!small && !must_be_matrix) return std::optional<RigidMotion>();
  if (!small)
    return bad_input(path, "expected four rows of four numbers; this file is larger than those");
  const auto text = read_file(path);
  if (!text) return text.error();
  if (!must_be_matrix && !holds_sixteen_numbers(*text)) return std::optional<RigidMotion>();
  const auto motion = parse_matrix_text(*text, path);
  if (!motion) return motion.error();
  return std::optional(*motion);
}

}  // namespace

Result<RigidMotion> parse_matrix_text(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  auto motion = parse_motion_rows(lines, "the pose");
  if (!motion) return motion.error();
  if (std::string_view line; lines.next(line))
    return lines.error("expected four rows of four numbers, and nothing behind them");
  return motion;
}

Result<std::optional<RigidMotion>> pose_beside(const fs::path& scan_path) {
  const fs::path folder = scan_path.parent_path();
  const std::string stem = scan_path.stem().string();
  for (const char* ending : {".xf", ".mat.txt", ".matrix.txt", "_matrix.txt"})
    if (const fs::path path = folder / (stem + ending); is_file(path))
      return read_matrix_file(path, true);
  const auto saved = registration_matrix(folder, stem);
  if (!saved) return saved.error();
  if (*saved) return read_matrix_file(**saved, true);
  const fs::path text = folder / (stem + ".txt");
  if (text != scan_path && is_file(text)) return read_matrix_file(text, false);
  return std::optional<RigidMotion>();
}

}  // namespace relief
