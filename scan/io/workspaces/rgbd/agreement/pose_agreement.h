#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "scan/io/images/image_io.h"
#include "scan/io/project/view_spec.h"
#include "scan/views/pose_convention.h"

namespace relief {

/// A way to read the depth maps of a project and their poses.
struct DepthReading {
  bool along_ray = false;  ///< Depths are distances along the rays, not along the optical axis.
  PoseConvention poses;
};

/// How much depth maps disagree at their poses.
struct Disagreement {
  double median = 0.0;     ///< Of |depth - z| / z over the pixels that meet.
  std::size_t pixels = 0;  ///< That meet.
};

/// The depth maps of a few pairs of frames, to be compared at their poses.
class ComparedDepths {
 public:
  /// Reads them. Pixels that stand still in all of them are left out: they disagree at the right
  /// poses.
  explicit ComparedDepths(const ProjectSpec& project);

  /// How much they disagree for each reading, at the scale and the poses that `project` has now.
  /// Pairs at the same pose agree in any reading and are left out, as are those that only_rolls()
  /// holds for in other conventions. Nothing where too few pixels meet, where frames have no poses,
  /// or where they could not be read.
  std::vector<std::optional<Disagreement>> disagreements(
      const ProjectSpec& project, const std::vector<DepthReading>& readings) const;

 private:
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::map<std::size_t, Image> depths_;  // By frame, as they are in the files.
};

/// Whether the depths of a project are taken as distances along the rays.
bool has_ray_lengths(const ProjectSpec& project);

/// How much better one reading must agree than another to be told from it. Scenes that are their
/// own mirror image agree alike; the views of a room (ICL-NUIM) agree nine times better in a
/// left-handed world, as they are meant.
inline constexpr double kFarBetter = 4.0;

/// What depth cameras err, relative to the depth.
inline constexpr double kCameraError = 0.02;

/// By how much no depth camera errs, relative to the depth.
inline constexpr double kBeyondCameraError = 0.1;

}  // namespace relief
