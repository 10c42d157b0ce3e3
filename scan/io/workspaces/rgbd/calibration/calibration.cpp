#include "scan/io/workspaces/rgbd/calibration/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/images/image_limits.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"
#include "scan/io/workspaces/rgbd/open3d_json.h"
#include "scan/io/workspaces/rgbd/replica_layout.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Calibration files are small; larger texts beside scans are something else.
constexpr std::uintmax_t kMaxCalibrationBytes = 1 << 16;

struct CalibrationLine {
  int number = 0;
  std::vector<double> numbers;
};

// What a calibration text holds: rows of numbers, and numbers with names.
struct CalibrationWords {
  std::vector<CalibrationLine> rows;
  std::array<std::optional<double>, 7> named;
};
constexpr std::array<std::string_view, 7> kCalibrationNames = {
    "fx", "fy", "cx", "cy", "width", "height", "depth_scale"};

// `fx 525`, `fx: 525` or `fx = 525`. False where the line has another form or an unknown name.
bool take_named(std::string_view line, CalibrationWords& words) {
  const std::size_t end = line.find_first_of(" \t:=,");
  const auto name =
      std::find(kCalibrationNames.begin(), kCalibrationNames.end(), line.substr(0, end));
  if (name == kCalibrationNames.end() || end == std::string_view::npos) return false;
  line.remove_prefix(end);
  line.remove_prefix(std::min(line.find_first_not_of(" \t:=,"), line.size()));
  double value = 0.0;
  if (!parse_row(line, 1, &value) || !std::isfinite(value)) return false;
  words.named[static_cast<std::size_t>(name - kCalibrationNames.begin())] = value;
  return true;
}

Result<CalibrationWords> calibration_words(std::string_view text, const fs::path& path) {
  NumberedLines lines(text, path);
  CalibrationWords words;
  for (std::string_view line; lines.next(line);) {
    const auto numbers = leading_numbers(line);
    const bool all_finite = std::all_of(numbers.begin(), numbers.end(),
                                        [](double number) { return std::isfinite(number); });
    if (!numbers.empty() && all_finite && words_of(line).size() == numbers.size())
      words.rows.push_back({lines.number(), numbers});
    else if (!take_named(line, words))
      return lines.error(
          "expected 'fx fy cx cy', a row of a 3x3 matrix, or a line as 'fx 525' (fx, fy, cx, cy, "
          "width, height, depth_scale)");
  }
  return words;
}

// `fx fy cx cy` and what may follow.
void take_single_row(const CalibrationLine& row, Calibration& calibration) {
  const std::vector<double>& n = row.numbers;
  calibration.intrinsics = PinholeIntrinsics{n[0], n[1], n[2], n[3]};
  // Coefficients of distortion are small or fractions, sizes are whole and large: no depth camera
  // has fewer pixels.
  constexpr double kSmallestSide = 16.0;
  if (n.size() == 6 && n[4] >= kSmallestSide && n[5] >= kSmallestSide) {
    calibration.size = size_of_numbers(n[4], n[5]);
    if (calibration.size) return;
  }
  if (std::any_of(n.begin() + 4, n.end(), [](double k) { return k != 0.0; }))
    calibration.notes.push_back("coefficients of distortion on line " + std::to_string(row.number) +
                                " are not applied");
}

Result<void> take_matrix(const std::vector<CalibrationLine>& rows, const fs::path& path,
                         Calibration& calibration) {
  const std::size_t size = rows.size();
  const auto place = [&](std::size_t r) { return "line " + std::to_string(rows[r].number) + ": "; };
  for (std::size_t r = 0; r < size; ++r) {
    if (rows[r].numbers.size() != size)
      return bad_input(path, place(r) + "expected a row of a " + std::to_string(size) + "x" +
                                 std::to_string(size) + " matrix of intrinsics");
    for (std::size_t c = 0; c < size; ++c) {
      const bool free = (r == c && r < 2) || (r < 2 && c == 2);
      if (!free && rows[r].numbers[c] != (r == c ? 1.0 : 0.0))
        return bad_input(path, place(r) +
                                   "a matrix of intrinsics is 'fx 0 cx', '0 fy cy', "
                                   "'0 0 1', without skew");
    }
  }
  const auto at = [&](std::size_t r, std::size_t c) { return rows[r].numbers[c]; };
  calibration.intrinsics = PinholeIntrinsics{at(0, 0), at(1, 1), at(0, 2), at(1, 2)};
  return {};
}

Result<void> take_rows(const CalibrationWords& words, const fs::path& path,
                       Calibration& calibration) {
  const auto& rows = words.rows;
  if (rows.empty()) return {};
  if (rows.size() == 3 || rows.size() == 4) return take_matrix(rows, path, calibration);
  const CalibrationLine& row = rows.front();
  if (rows.size() == 1 && row.numbers.size() >= 4 && row.numbers.size() <= 12) {
    take_single_row(row, calibration);
    return {};
  }
  return bad_input(path, "line " + std::to_string(row.number) +
                             ": expected 'fx fy cx cy' on one line, or a 3x3 matrix");
}

Result<void> take_names(const CalibrationWords& words, const fs::path& path,
                        Calibration& calibration) {
  const auto& [fx, fy, cx, cy, width, height, scale] = words.named;
  if (fx && fy && cx && cy)
    calibration.intrinsics = PinholeIntrinsics{*fx, *fy, *cx, *cy};
  else if (fx || fy || cx || cy)
    return bad_input(path, "needs all of fx, fy, cx and cy");
  if (width && height) calibration.size = size_of_numbers(*width, *height);
  if (scale && !(*scale > 0.0)) return bad_input(path, "depth_scale must be positive, as 1000");
  if (scale) calibration.depth_scale = *scale;
  return {};
}

// Whether a file that is named like a calibration is one, or has an error. Others may hold
// something else.
bool must_be_calibration(const fs::path& path, std::string_view text) {
  const std::string ending = lower_ending(path);
  return ending == ".txt" || path.filename() == "cam_params.json" ||
         (ending == ".json" && looks_like_open3d_camera(text));
}

std::optional<Calibration> other_calibration(std::string_view text, const fs::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".json"  ? parse_camera_json(text)
         : ending == ".npy" ? parse_camera_npy(text, path)
                            : parse_camera_yaml(text, path);
}

Result<std::optional<Calibration>> certain_calibration(std::string_view text,
                                                       const fs::path& path) {
  auto calibration = path.filename() == "cam_params.json" ? parse_replica_camera(text, path)
                     : lower_ending(path) == ".json"      ? parse_open3d_camera(text, path)
                                                          : parse_calibration_text(text, path);
  if (!calibration) return calibration.error();
  return std::optional(std::move(*calibration));
}

struct FoundCalibration {
  fs::path file;
  Calibration calibration;
  bool is_other = false;      // Of a file that may hold something else.
  bool is_not_depth = false;  // Its name does not say `depth`.

  auto order() const { return std::pair(is_other, is_not_depth); }
};

// The calibration in a file, if it is one.
Result<std::optional<FoundCalibration>> calibration_of_file(const fs::path& path) {
  std::error_code code;
  std::optional<FoundCalibration> found;
  if (!has_calibration_name(path)) return found;
  if (fs::file_size(path, code) > kMaxCalibrationBytes || code) return found;
  const auto text = read_file(path);
  if (!text) return text.error();
  const bool is_other = !must_be_calibration(path, *text);
  auto calibration = is_other ? Result<std::optional<Calibration>>(other_calibration(*text, path))
                              : certain_calibration(*text, path);
  if (!calibration) return calibration.error();
  if (*calibration)
    found = {path, std::move(**calibration), is_other,
             path.stem().string().find("depth") == std::string::npos};
  return found;
}

bool have_same_intrinsics(const Calibration& a, const Calibration& b) {
  const auto numbers = [](const Calibration& c) {
    const PinholeIntrinsics k = c.intrinsics.value_or(PinholeIntrinsics{});
    return std::array{k.fx, k.fy, k.cx, k.cy};
  };
  return numbers(a) == numbers(b);
}

// What all that go first say. Those after them only add a scale. An error where they differ.
Result<FoundCalibration> combined(std::vector<FoundCalibration> found) {
  std::ranges::stable_sort(found, {}, &FoundCalibration::order);
  FoundCalibration& first = found.front();
  for (std::size_t k = 1; k < found.size(); ++k) {
    const Calibration& next = found[k].calibration;
    const bool same = have_same_intrinsics(first.calibration, next);
    const bool same_scale = !first.calibration.depth_scale || !next.depth_scale ||
                            *first.calibration.depth_scale == *next.depth_scale;
    if (found[k].order() == first.order() && (!same || !same_scale))
      return bad_input(found[k].file,
                       "differs from " + first.file.filename().string() +
                           " beside it; leave the calibration of the depth camera only");
    if (same && !first.calibration.depth_scale) first.calibration.depth_scale = next.depth_scale;
  }
  return std::move(first);
}

// Beside the folders of frames: Replica has one for all scenes, as others have.
bool is_calibration_of_folders(const fs::path& path) {
  return path.filename() == "cam_params.json" ||
         (lower_ending(path) == ".txt" &&
          path.stem().string().find("intrinsic") != std::string::npos);
}

// Nothing where none of the files is one.
Result<std::optional<Calibration>> calibration_among(const std::vector<fs::path>& files) {
  std::vector<FoundCalibration> all;
  for (const fs::path& path : files) {
    auto found = calibration_of_file(path);
    if (!found) return found.error();
    if (*found) all.push_back(std::move(**found));
  }
  if (all.empty()) return std::optional<Calibration>();
  auto found = combined(std::move(all));
  if (!found) return found.error();
  auto& [file, calibration, is_other, is_not_depth] = *found;
  calibration.notes.insert(calibration.notes.begin(), "intrinsics from " + file.string());
  return std::optional(std::move(calibration));
}

}  // namespace

std::optional<ImageSize> size_of_numbers(double width, double height) {
  const auto is_side = [](double side) {
    return side >= 1.0 && side <= kMaxImageSide && side == std::floor(side);
  };
  if (!is_side(width) || !is_side(height)) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

bool can_be_intrinsics(const PinholeIntrinsics& k) {
  const auto usable = [](double focal) { return std::isfinite(focal) && focal != 0.0; };
  return usable(k.fx) && usable(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy);
}

bool has_calibration_name(const fs::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".json" || ending == ".yaml" || ending == ".yml") return true;
  const std::string stem = path.stem().string();
  const auto has = [&](const char* part) { return stem.find(part) != std::string::npos; };
  return (ending == ".txt" || ending == ".npy") && !has("traj") &&
         (has("calib") || has("intrinsic") || stem.starts_with("camera") || stem == "K");
}

Result<Calibration> parse_calibration_text(std::string_view text, const fs::path& path) {
  const auto words = calibration_words(text, path);
  if (!words) return words.error();
  Calibration calibration;
  if (auto taken = take_rows(*words, path, calibration); !taken) return taken.error();
  if (auto taken = take_names(*words, path, calibration); !taken) return taken.error();
  if (!calibration.intrinsics && !calibration.depth_scale)
    return bad_input(path, "no intrinsics in it; write 'fx fy cx cy' on one line");
  if (calibration.intrinsics &&
      (calibration.intrinsics->fx == 0.0 || calibration.intrinsics->fy == 0.0))
    return bad_input(path, "the focal lengths fx and fy must not be 0");
  return calibration;
}

std::optional<PinholeIntrinsics> intrinsics_of_matrix(std::span<const double> numbers) {
  if (numbers.size() != 9) return std::nullopt;
  const bool has_skew = numbers[1] != 0.0 || numbers[3] != 0.0;
  if (has_skew || numbers[6] != 0.0 || numbers[7] != 0.0 || numbers[8] != 1.0) return std::nullopt;
  const PinholeIntrinsics k{numbers[0], numbers[4], numbers[2], numbers[5]};
  return can_be_intrinsics(k) ? std::optional(k) : std::nullopt;
}

Result<std::optional<Calibration>> find_calibration(const fs::path& folder) {
  for (const char* of_its_own : {"intrinsic", "intrinsics"})
    if (fs::is_directory(folder / of_its_own))
      if (auto found = find_calibration(folder / of_its_own); !found || *found) return found;
  return calibration_among(files_in(folder));
}

Result<std::optional<Calibration>> find_calibration_beside(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::path& file : files_in(folder / ".."))
    if (is_calibration_of_folders(file)) files.push_back(file.lexically_normal());
  return calibration_among(files);
}

}  // namespace relief
