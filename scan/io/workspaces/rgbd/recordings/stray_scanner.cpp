#include "scan/io/workspaces/rgbd/recordings/stray_scanner.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

constexpr ImageSize kVideo{1920, 1440}, kDepth{256, 192};
constexpr double kDepthScale = 1000.0;                     // Values per metre.
constexpr std::size_t kPose = 9, kPoseAndIntrinsics = 13;  // Numbers of a line of odometry.

// Of the depth maps, whose pixels cover several of the video's: centres are at whole numbers.
PinholeIntrinsics scaled_to_depth(double fx, double fy, double cx, double cy) {
  const double x = static_cast<double>(kDepth.width) / kVideo.width;
  const double y = static_cast<double>(kDepth.height) / kVideo.height;
  return {x * fx, y * fy, x * (cx + 0.5) - 0.5, y * (cy + 0.5) - 0.5};
}

std::string with_blanks(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  return text;
}

Result<PinholeIntrinsics> parse_camera_matrix(const std::string& text, const fs::path& path) {
  NumberedLines lines(text, path);
  double k[3][3];
  for (auto& row : k) {
    std::string_view line;
    if (!lines.next(line)) return lines.end_error("a row of the camera matrix");
    if (!parse_row(line, 3, row)) return lines.error("expected a row of three numbers");
  }
  const PinholeIntrinsics depth = scaled_to_depth(k[0][0], k[1][1], k[0][2], k[1][2]);
  if (!can_be_intrinsics(depth)) return bad_input(path, "the focal lengths must not be 0");
  return depth;
}

Result<void> parse_odometry(const std::string& text, const fs::path& path, Recording& recording) {
  NumberedLines lines(text, path);
  std::string_view line;
  if (!lines.next(line)) return lines.end_error("the header");
  while (lines.next(line)) {
    const auto n = leading_numbers(line);
    if ((n.size() != kPose && n.size() != kPoseAndIntrinsics) || !(n[1] >= 0.0) || !(n[1] < 1e9))
      return lines.error("expected time, frame, x, y, z, qx, qy, qz, qw");
    const auto pose = motion_of_quaternion({n[8], n[5], n[6], n[7]}, {n[2], n[3], n[4]});
    if (!pose) return lines.error("the quaternion has not the length 1");
    RecordedFrame& frame = recording.frames[static_cast<int>(n[1])];
    frame.world_from_view = *pose;
    if (n.size() == kPoseAndIntrinsics)
      frame.intrinsics = scaled_to_depth(n[9], n[10], n[11], n[12]);
  }
  return {};
}

}  // namespace

Result<std::optional<Recording>> read_stray_scanner(const fs::path& folder) {
  const fs::path matrix = folder / "camera_matrix.csv", odometry = folder / "odometry.csv";
  if (!is_file(matrix)) return std::optional<Recording>();
  const auto text = read_file(matrix);
  if (!text) return text.error();
  const auto intrinsics = parse_camera_matrix(with_blanks(*text), matrix);
  if (!intrinsics) return intrinsics.error();
  Recording recording;
  recording.calibration.intrinsics = *intrinsics;
  recording.calibration.size = kDepth;
  recording.calibration.depth_scale = kDepthScale;
  recording.calibration.notes.push_back("intrinsics from " + matrix.string());
  std::error_code code;
  if (fs::is_directory(folder / "confidence", code)) {
    recording.masks = folder / "confidence";
    recording.calibration.notes.push_back(
        "depths of confidence 0, the least of three, are left out");
  }
  if (is_file(odometry)) {
    const auto poses = read_file(odometry);
    if (!poses) return poses.error();
    if (auto parsed = parse_odometry(with_blanks(*poses), odometry, recording); !parsed)
      return parsed.error();
    recording.calibration.notes.push_back("poses from " + odometry.string());
  }
  return std::optional(std::move(recording));
}

}  // namespace relief
