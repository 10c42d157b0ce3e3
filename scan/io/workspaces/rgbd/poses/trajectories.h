#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/images/image_size.h"

namespace relief {

/// A line of the lists `depth.txt` and `rgb.txt` of a TUM sequence.
struct TimedFile {
  double time = 0.0;  ///< [s]
  std::string file;   ///< As it stands in the list.
};

/// A line of an association file: one moment of both cameras.
struct FilePair {
  TimedFile depth, colour;
};

struct TrajectoryPose {
  std::optional<double> time;  ///< [s]; none in formats that count frames.
  RigidMotion world_from_view = RigidMotion::Identity();
  bool is_lost = false;  ///< The tracker had lost the camera: its numbers are no pose.
  std::optional<PinholeIntrinsics> intrinsics;  ///< Where the trajectory has them.
  std::optional<ImageSize> size;                ///< With the intrinsics.
};
using Trajectory = std::vector<TrajectoryPose>;

/// World from view of each frame; nothing where it is not known.
using PosesOfFrames = std::vector<std::optional<RigidMotion>>;

/// Parses lines `time file`. Lines before the first that begins with a number are a header.
Result<std::vector<TimedFile>> parse_tum_list(std::string_view text,
                                              const std::filesystem::path& path);

/// Parses lines `time file time file`. The depth file is the one whose path says `depth`; where
/// none does, the second, as in the files of TUM's own tool.
Result<std::vector<FilePair>> parse_tum_associations(std::string_view text,
                                                     const std::filesystem::path& path);

/// Parses lines `time tx ty tz qx qy qz qw`, world from view, or the same without the time: then
/// the poses are in the order of the frames. Understands a first pose on the line of the header,
/// behind it (`# ... <qw>0.0 1 2 3 0 0 0 1`), as Open3D writes it. Times must not decrease. Poses
/// with numbers that are not finite, or with a quaternion of zeros, are lost.
Result<Trajectory> parse_tum_trajectory(std::string_view text, const std::filesystem::path& path);

/// Parses a pose a line: the 12 numbers of a 3x4 matrix by rows (KITTI) or the 16 of a 4x4 matrix
/// (Replica), world from view, in the order of the frames. Those with numbers that are not finite,
/// or with zeros alone, are lost.
Result<Trajectory> parse_matrix_trajectory(std::string_view text,
                                           const std::filesystem::path& path);

/// Parses the `.log` of Open3D and Redwood: a line of three whole numbers, then world from view in
/// four rows, lost as those of parse_matrix_trajectory(). kBadInput for a list of relative poses of
/// pairs.
Result<Trajectory> parse_log_trajectory(std::string_view text, const std::filesystem::path& path);

/// Parses a PinholeCameraTrajectory of Open3D: `extrinsic` is view from world, column by column.
Result<Trajectory> parse_open3d_trajectory(std::string_view text,
                                           const std::filesystem::path& path);

/// The kinds of text that an RGB-D folder can have, told by their first lines of data.
enum class RgbdText {
  kUnknown,
  kList,
  kAssociations,
  kTumPoses,
  kPlainPoses,
  kLogPoses,
  kMatrixPoses
};
RgbdText kind_of_rgbd_text(std::string_view text);

/// What is wrong with the first line of numbers of a text that is kUnknown, where these are as many
/// as poses have, about. Nothing for other texts.
std::optional<Error> error_of_first_pose(std::string_view text, const std::filesystem::path& path);

/// The pose at `time`: between the two neighbours when both lie within `tolerance` [s] of it, else
/// that of the nearest one within it. Nothing where there is none, or where one of those is lost.
/// Poses are ordered by time.
std::optional<RigidMotion> pose_at(const Trajectory& trajectory, double time, double tolerance);

}  // namespace relief
