// Projects of relief and of other programs.
#include <cstdint>
#include <string>

#include "relief/io/project_io.h"
#include "scan/io/files/binary_writer.h"
#include "tests/fuzz/corpus_folder.h"
#include "tests/fuzz/workspace_parsers.h"

namespace relief::testing {

namespace {

const std::string kRows = "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n";

const std::string kProject =
    R"({"format": "relief-scan", "version": 1, "unit": "mm", "views": [
{"name": "a", "depth": {"file": "a.tiff", "scale": 1.0, "kind": "z"},
 "camera": {"model": "pinhole", "width": 9, "height": 7, "fx": 16, "fy": 16, "cx": 4, "cy": 3},
 "normals": {"file": "n.png", "encoding": "rgb", "axes": "opengl", "space": "camera"},
 "mask": {"file": "m.png"}, "confidence": {"file": "c.raw", "size": [9, 7]},
 "world_from_view": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "pose_is": "known"},
{"name": "b", "grid": {"file": "b.e57", "scan": 1, "viewpoint": [0,0,1], "pose": "ignore"},
 "camera": {"model": "spherical", "width": 3, "height": 2, "azimuth": [0, 10, 20],
            "elevation": 5, "elevation_step": -1}},
{"name": "c", "depth": {"file": "c.pfm", "kind": "ray"}, "samples": "refined",
 "deviation": {"file": "d.tiff", "scale": 2},
 "camera": {"model": "orthographic", "origin": [0,0,0], "step_u": [1,0,0], "step_v": [0,1,0],
            "view_direction": [0,0,1]}}]})";

std::string colmap_cameras() {
  std::string bytes;
  append_little_endian<std::uint64_t>(bytes, 1);
  for (const std::uint32_t number : {1u, 1u}) append_little_endian(bytes, number);
  for (const std::uint64_t side : {8u, 6u}) append_little_endian(bytes, side);
  for (const double number : {5.0, 5.0, 4.0, 3.0}) append_little_endian(bytes, number);
  return bytes;
}

std::string colmap_images() {
  std::string bytes;
  append_little_endian<std::uint64_t>(bytes, 1);
  append_little_endian<std::uint32_t>(bytes, 1);
  append_little_endian(bytes, 1.0);
  for (int i = 0; i < 6; ++i) append_little_endian(bytes, 0.0);
  append_little_endian<std::uint32_t>(bytes, 1);
  bytes += std::string("a.jpg\0", 6);
  append_little_endian<std::uint64_t>(bytes, 1);
  return bytes + std::string(24, '\0');
}

std::string colmap_points() {
  std::string bytes;
  append_little_endian<std::uint64_t>(bytes, 1);
  append_little_endian<std::uint64_t>(bytes, 1);
  bytes.append(3 * 8 + 3 + 8, '\1');
  append_little_endian<std::uint64_t>(bytes, 1);
  return bytes + std::string(8, '\2');
}

void add_workspace(const CorpusFolder& corpus, std::string_view parser,
                   const std::string& content) {
  char selector = 0;
  while (kWorkspaceParsers.at(static_cast<std::size_t>(selector)).name != parser) ++selector;
  corpus.add("workspaces", std::string(parser), selector + content);
}

}  // namespace

void add_projects(const CorpusFolder& corpus) {
  corpus.add("scan_json", "scan.json", kProject);
  corpus.add("conf", "a.conf", "camera 1 2 3 0 0 0 1\nbmesh a.ply 0 0 1 0 0 0 1\n");
  corpus.add("aln", "a.aln", "1\na.ply\n#\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0\n");
  corpus.add("poses", "a.json",
             "{\"views\":[{\"name\":\"a\",\"world_from_view\":[[1,0,0,0],[0,1,0,0],[0,0,1,0],"
             "[0,0,0,1]]}]}\n");
}

void add_workspaces(const CorpusFolder& corpus) {
  const auto add = [&](std::string_view parser, const std::string& content) {
    add_workspace(corpus, parser, content);
  };
  add("colmap_array", "2&1&1&" + std::string(8, '\1'));
  add("colmap_cameras_bin", colmap_cameras());
  add("colmap_images_bin", colmap_images());
  add("colmap_points_bin", colmap_points());
  add("colmap_cameras_txt", "7 PINHOLE 8 6 10 12 4 3\n");
  add("colmap_images_txt", "3 1 0 0 0 0 0 0 7 a.jpg\n1 2 3\n");
  add("colmap_points_txt", "1 0.1 0.1 2 1 2 3 0.5 3 0\n");
  add("tum_list", "# d\ntimestamp filename\n1.5 a.png\n2.5 b.png\n");
  add("tum_associations", "1 a.png 1 b.png\n2 c.png 2 d.png\n");
  add("tum_trajectory", "# <qw>1 0 0 0 0 0 0 1\n2 1 2 3 0 0 0 1\n");
  add("log_trajectory", "0 0 1\n" + kRows + "1 1 2\n" + kRows);
  add("open3d_trajectory",
      R"({"parameters": [{"extrinsic": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1], "intrinsic":
      {"width": 4, "height": 3, "intrinsic_matrix": [5,0,0, 0,5,0, 2,1,1]}}]})");
  add("nerf_transforms",
      R"({"fl_x": 5, "w": 4, "h": 3, "frames": [{"depth_path": "a.png", "transform_matrix": )"
      "[[1,0,0,1], [0,1,0,2], [0,0,1,3], [0,0,0,1]]}]}");
  add("open3d_camera", R"({"width": 4, "height": 3, "intrinsic_matrix": [5,0,0, 0,5,0, 2,1,1]})");
  add("calibration", "fx 5\nfy -5\ncx 5\ncy 5\ndepth_scale 1000\n");
  add("camera_json", R"({"fx": 5, "fy": 5, "cx": 5, "cy": 5, "width": 9, "height": 7})");
  add("camera_yaml", "Camera.fx: 5\nCamera.fy: 5\nCamera.cx: 5\nCamera.cy: 5\n");
  add("json_poses", R"([{"name": "a", "T": [1,0,0,0, 0,1,0,0, 0,0,1,0]}])");
  add("pose_table", "frame,tx,ty,tz,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n");
  add("matrix", kRows);
  add("middlebury", "1\na 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n");
  add("mlp", "<MeshLabProject><MeshGroup><MLMesh filename=\"a.ply\"><MLMatrix44>\n" + kRows +
                 "</MLMatrix44></MLMesh></MeshGroup></MeshLabProject>\n");
}

}  // namespace relief::testing
