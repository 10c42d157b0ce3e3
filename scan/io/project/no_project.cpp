#include "scan/io/project/no_project.h"

#include <algorithm>
#include <array>
#include <string>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_size.h"
#include "scan/io/workspaces/rgbd/open3d_json.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

namespace {

struct KnownEnding {
  const char* ending;
  const char* remedy;
};

constexpr const char* kPoses =
    "holds poses, not what was measured; name the folder with the scans or depth maps beside it";
constexpr const char* kOfScanners = "unknown format of scans; export it as E57, PTX or XYZ text";
constexpr const char* kWrittenOnly =
    "this format is only written; convert it to .ply, .obj or .stl first";

constexpr std::array kKnownEndings{
    KnownEnding{".log", kPoses},
    KnownEnding{".tum", kPoses},
    KnownEnding{".xf", kPoses},
    KnownEnding{".traj", kPoses},
    KnownEnding{".freiburg", kPoses},
    KnownEnding{".fc", "holds intrinsics; give it as --fc, beside the range grid"},
    KnownEnding{".bin",
                "holds no points of a lidar (floats: x y z in metres, an intensity below 256, and "
                "perhaps a ring); if it is a part of a COLMAP workspace, name the folder with "
                "sparse and stereo"},
    KnownEnding{".vtk", "is of VTK's older format; convert it to .vtp, .ply or .xyz"},
    KnownEnding{".las", kOfScanners},
    KnownEnding{".laz", kOfScanners},
    KnownEnding{".rcp", kOfScanners},
    KnownEnding{".fls", kOfScanners},
    KnownEnding{".zfs", kOfScanners},
    KnownEnding{".glb", kWrittenOnly},
    KnownEnding{".3mf", kWrittenOnly}};

bool is_image(const std::filesystem::path& path) {
  return has_depth_image_ending(path) || has_photograph_ending(path);
}

// Points may have as many columns as a trajectory: its quaternions tell it.
bool is_trajectory(const std::filesystem::path& path) {
  const auto text = read_file(path);
  return text.ok() && parse_tum_trajectory(*text, path).ok();
}

}  // namespace

Error why_no_project(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  const auto known = std::find_if(kKnownEndings.begin(), kKnownEndings.end(),
                                  [&](const KnownEnding& k) { return ending == k.ending; });
  if (known != kKnownEndings.end()) return bad_input(path, known->remedy);
  if (belongs_to_depth_maps(path))
    return bad_input(path, "belongs to depth maps; name the folder that they lie in");
  if (is_image(path))
    return bad_input(path,
                     "is an image without a camera; 'relief init FOLDER' writes a scan.json for "
                     "the images of a folder");
  return bad_input(path, "unknown project format '" + path.extension().string() +
                             "'; use a scan.json, a .conf, .aln or .mlp, a file of scans (.ply "
                             ".pcd .ptx .e57 .xyz .pts .obj .stl .vtp), or a folder");
}

bool belongs_to_depth_maps(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  if (ending != ".json" && ending != ".txt") return false;
  const std::string head = first_bytes(path);
  if (ending == ".json") return looks_like_open3d_camera(head);
  const RgbdText kind = kind_of_rgbd_text(head);
  if (kind == RgbdText::kTumPoses) return is_trajectory(path);
  return kind == RgbdText::kLogPoses || kind == RgbdText::kList || kind == RgbdText::kAssociations;
}

}  // namespace relief
