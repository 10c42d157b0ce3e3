#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "relief/io/project_io.h"
#include "relief/scan/camera.h"
#include "relief/scan/projections.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/images/image_size.h"

namespace relief {

/// An image of a view. `size` is needed for bare floats, and checked for others.
struct ImageFile {
  std::filesystem::path file;
  std::optional<ImageSize> size = {};
};

struct DepthSpec {
  std::filesystem::path file;
  double scale = 1.0;      ///< Value times scale is in the project's unit.
  bool along_ray = false;  ///< `kind` `ray`: distance along the ray; else `z`.
  std::optional<ImageSize> size = {};
};

struct DeviationSpec {
  std::filesystem::path file;
  double scale = 1.0;  ///< Value times scale is in the project's unit.
  std::optional<ImageSize> size = {};
};

/// The `camera` of a view. Which members are set depends on `model`.
struct CameraSpec {
  enum class Model { kPinhole, kPinholeGl, kOrthographic, kRational, kSpherical };
  Model model = Model::kPinhole;
  std::optional<int> width, height;
  PinholeIntrinsics intrinsics;
  std::optional<Eigen::Vector3d> view_direction;          ///< Orthographic, rational.
  std::optional<Eigen::Vector3d> origin, step_u, step_v;  ///< Orthographic.
  RationalProjection projection;
  SphericalProjection angles;  ///< As tables; their lengths are `width` and `height`.
};

enum class NormalEncoding { kRgb, kUnit };
enum class NormalAxes { kOpencv, kOpengl };
enum class NormalSpace { kCamera, kWorld };

struct NormalSpec {
  std::filesystem::path file;
  std::optional<NormalEncoding> encoding;  ///< What is left out is found from the data.
  std::optional<NormalAxes> axes;
  std::optional<NormalSpace> space;
  std::optional<ImageSize> size = {};
};

/// What a file of scans leaves open.
struct GridOptions {
  int scan = 0;  ///< Which scan of a file that holds several, from 0.
  /// Where the sensor stood, in the file's frame; for points without a grid. Else it is found.
  std::optional<Eigen::Vector3d> viewpoint;
  bool ignore_pose = false;  ///< The pose that the file tells is not taken.
  /// Files that tell no pose are all in one frame: their pose is the identity, a guess.
  bool shared_frame = false;
  /// Where the scan is in a PTX file, where that is known: it is read without those before it.
  std::optional<PtxScan> ptx = {};
};

/// One view as a project describes it, before its data is read. File names are resolved.
struct ViewSpec {
  std::string name;
  std::optional<DepthSpec> depth;             ///< Either this
  std::optional<std::filesystem::path> grid;  ///< or this is set.
  GridOptions grid_options;
  std::optional<CameraSpec> camera;
  std::optional<NormalSpec> normals;
  std::optional<ImageFile> mask, confidence, colour;
  std::optional<DeviationSpec> deviation;
  RigidMotion world_from_view = RigidMotion::Identity();
  PoseKind pose = PoseKind::kAbsent;
  SampleOrigin samples = SampleOrigin::kRaw;
};

struct ProjectSpec {
  std::filesystem::path file;  ///< That describes the views, as a scan.json; empty: none does.
  std::string unit;
  std::vector<ViewSpec> views;
  std::vector<std::string> notes;
};

/// Parses the text of a scan.json. Strict: an unknown key, a wrong type, a pose that is no rigid
/// motion are errors (kBadInput) that name the place, such as `views[3].camera.fz`. Pinholes with a
/// focal length of 0, as drafts have them, take the intrinsics `of_drafts`.
Result<ProjectSpec> parse_scan_json(const std::string& text, const std::filesystem::path& path,
                                    const std::optional<PinholeIntrinsics>& of_drafts = {});

/// Parses the text of a Stanford .conf: `bmesh FILE tx ty tz qx qy qz qw`.
Result<ProjectSpec> parse_stanford_conf(const std::string& text, const std::filesystem::path& path);

/// Parses the text of a MeshLab .aln: the number of meshes, and for each a file name, a line `#`
/// and the matrix world_from_view in four rows.
Result<ProjectSpec> parse_meshlab_aln(const std::string& text, const std::filesystem::path& path);

/// Whether the ending of a path is that of a file that names the files of views.
bool is_project_file(const std::filesystem::path& path);

/// What read_project's `path` stands for, whichever form it has.
Result<ProjectSpec> read_project_spec(const std::filesystem::path& path,
                                      const ReadProjectOptions& options = {});

}  // namespace relief
