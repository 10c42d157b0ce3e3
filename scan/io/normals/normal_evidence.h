#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scan/io/normals/map_placement.h"
#include "scan/io/normals/normal_convention.h"
#include "scan/io/normals/normal_patches.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// What was done to the values of a normal image, from 0 to 1, as if they were colours.
enum class TransferCurve {
  kNone,
  kSrgb,        ///< Encoded with the curve of sRGB (IEC 61966-2-1), as linear light for a screen.
  kPower,       ///< Encoded with the power 1 / 2.2.
  kSrgbLinear,  ///< Taken for sRGB and decoded to linear light.
  kPowerLinear  ///< The same with the power 2.2.
};

/// What is known of the normals of one view before their convention is settled.
struct NormalEvidence {
  std::string view;            ///< Name.
  std::filesystem::path file;  ///< That holds the normals.
  NormalFileKind kind = NormalFileKind::kImage;
  NormalEncoding encoding = NormalEncoding::kUnit;
  TransferCurve curve = TransferCurve::kNone;  ///< Undone already.
  /// The usual conventions that agree with what the project states, the likelier first; one alone
  /// if it states all.
  std::vector<NormalConvention> usual;
  bool declared = false;  ///< The project or the format states all of it.
  Eigen::Matrix3d view_from_camera = Eigen::Matrix3d::Identity();  ///< May be a reflection.
  Eigen::Matrix3d view_from_world = Eigen::Matrix3d::Identity();
  bool has_pose = false;  ///< Without it nothing is in world space.
  NormalPatches patches;
  std::optional<MapPlacement> placement;  ///< Of an image that lies wrong.

  /// Takes stored components into the view frame.
  Eigen::Matrix3d view_from_stored(const NormalConvention& convention) const;
  bool possible(const NormalConvention& convention) const {
    return has_pose || convention.space == NormalSpace::kCamera;
  }
};

/// Whether a stored vector is a normal, by its length.
inline bool is_direction(const Eigen::Vector3d& vector) {
  const double length = vector.norm();
  return length >= 0.5 && length <= 1.5;
}

/// The normals of one view as a file holds them.
struct StoredNormals {
  Grid<Eigen::Vector3f> components;  ///< Decoded, in stored order; NaN where nothing is stored.
  NormalEvidence evidence;
  std::vector<std::string> notes;
};

/// How far the stored normals are from those of the depth.
struct NormalAgreement {
  double median = 0.0;  ///< Of the angle [rad].
  double bias = 0.0;    ///< The same less what the noise of the depth explains [rad].
};
NormalAgreement agreement(const NormalEvidence& evidence, const NormalConvention& convention);

/// The error that photometric stereo may have over large areas [rad]: within it a convention fits,
/// and beyond it normals are not used. A real panel has 10.6 deg (docs/results.md, Real scans).
inline constexpr double kLargestBias = 0.2618;  // 15 deg

/// Farther off, a map does not belong to its depth [rad]: two unrelated normals of a visible half
/// sphere have a mean cosine of (2/3)^2, 64 deg, and no sensor has such a bias.
inline constexpr double kUnrelatedBias = 0.611;  // 35 deg

/// With fewer patches no angle to the depth is believed.
inline constexpr std::size_t kFewestPatches = 8;

}  // namespace relief
