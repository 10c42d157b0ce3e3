// The parsers of other programs' projects on damaged files: each prefix and many random changes of
// a valid file must give an error or a value, never a crash or a huge allocation.
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "scan/io/files/binary_writer.h"
#include "scan/io/images/codecs/floats/colmap_array.h"
#include "scan/io/workspaces/colmap/colmap_model.h"
#include "scan/io/workspaces/meshlab_mlp.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/pose_beside.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"
#include "scan/io/workspaces/rgbd/calibration/camera_files.h"
#include "scan/io/workspaces/rgbd/poses/named_poses.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

using Parser = std::function<bool(const std::string&)>;

template <typename T>
Parser parser(Result<T> (*parse)(std::string_view, const std::filesystem::path&)) {
  return [parse](const std::string& content) { return parse(content, "a").ok(); };
}

void try_damage(const std::string& content, const Parser& parse) {
  ASSERT_TRUE(parse(content));
  for (std::size_t size = 0; size < content.size(); ++size) parse(content.substr(0, size));
  std::mt19937 random(7);
  for (int k = 0; k < 2000; ++k) {
    std::string changed = content;
    const std::size_t changes = 1 + random() % 4;
    for (std::size_t i = 0; i < changes; ++i)
      changed[random() % changed.size()] =
          static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
    parse(changed);
  }
}

const std::string kRows = "1 0 0 5\n0 0 -1 6\n0 1 0 7\n0 0 0 1\n";

TEST(DamagedWorkspaces, Texts) {
  try_damage("# d\ntimestamp filename\n1.5 a.png\n2.5 b.png\n", parser(parse_tum_list));
  try_damage("1 a.png 1 b.png\n2 c.png 2 d.png\n", parser(parse_tum_associations));
  try_damage("# <qw>1 0 0 0 0 0 0 1\n2 1 2 3 0 0 0 1\n", parser(parse_tum_trajectory));
  try_damage("0 0 1\n" + kRows + "1 1 2\n" + kRows, parser(parse_log_trajectory));
  try_damage("fx 5\nfy 5\ncx 5\ncy 5\ndepth_scale 1000\n", parser(parse_calibration_text));
  try_damage("5 0 1\n0 5 1\n0 0 1\n", parser(parse_calibration_text));
  try_damage(kRows, parser(parse_matrix_text));
  const Parser yaml = [](const std::string& text) {
    return parse_camera_yaml(text, "a").has_value();
  };
  try_damage("Camera.fx: 5\nCamera.fy: 5\nCamera.cx: 5\nCamera.cy: 5\n", yaml);
  try_damage("camera_matrix:\n  data: [5, 0, 7, 0, 6, 8, 0, 0, 1]\n", yaml);
  try_damage("frame,tx,ty,tz,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n", parser(parse_pose_table));
  try_damage("a 1 2 3 0 0 0 1\nb 1 2 3 0 0 0 1\n", parser(parse_pose_table));
  try_damage("1\na 1 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n", parser(parse_middlebury_par));
  try_damage("7 PINHOLE 8 6 10 12 4 3\n", parser(parse_colmap_cameras_txt));
  try_damage("3 1 0 0 0 0 0 0 7 a.jpg\n1 2 3\n", parser(parse_colmap_images_txt));
  try_damage("1 0.1 0.1 2 1 2 3 0.5 3 0\n", parser(parse_colmap_points_txt));
}

TEST(DamagedWorkspaces, Json) {
  try_damage(R"({"fx": 5, "fy": 5, "cx": 5, "cy": 5, "width": 9, "height": 7})",
             [](const std::string& text) { return parse_camera_json(text).has_value(); });
  try_damage(R"([{"name": "a", "T": [1,0,0,0, 0,1,0,0, 0,0,1,0]}])", parser(parse_json_poses));
  try_damage(R"({"width": 4, "height": 3, "intrinsic_matrix": [5,0,0, 0,5,0, 2,1,1]})",
             parser(parse_open3d_camera));
  try_damage(R"({"parameters": [{"extrinsic": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1], "intrinsic":
             {"width": 4, "height": 3, "intrinsic_matrix": [5,0,0, 0,5,0, 2,1,1]}}]})",
             parser(parse_open3d_trajectory));
}

TEST(DamagedWorkspaces, MeshLabProject) {
  try_damage("<MeshLabProject><MeshGroup><MLMesh filename=\"a.ply\"><MLMatrix44>\n" + kRows +
                 "</MLMatrix44></MLMesh></MeshGroup></MeshLabProject>\n",
             [](const std::string& text) { return parse_meshlab_mlp(text, "a.mlp").ok(); });
}

std::string small_points() {
  std::string bytes;
  append_little_endian<std::uint64_t>(bytes, 1);
  append_little_endian<std::uint64_t>(bytes, 1);
  bytes.append(3 * 8 + 3 + 8, '\1');
  append_little_endian<std::uint64_t>(bytes, 1);
  return bytes + std::string(8, '\2');
}

std::string small_images() {
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

std::string small_cameras() {
  std::string bytes;
  append_little_endian<std::uint64_t>(bytes, 1);
  for (std::uint32_t number : {1u, 1u}) append_little_endian(bytes, number);
  for (std::uint64_t side : {8u, 6u}) append_little_endian(bytes, side);
  for (double number : {5.0, 5.0, 4.0, 3.0}) append_little_endian(bytes, number);
  return bytes;
}

TEST(DamagedWorkspaces, Colmap) {
  for (const std::string& whole : {small_cameras(), small_images(), small_points()})
    EXPECT_FALSE(whole.empty());
  try_damage(small_cameras(), parser(parse_colmap_cameras_bin));
  try_damage(small_images(), parser(parse_colmap_images_bin));
  try_damage(small_points(), parser(parse_colmap_points_bin));
  try_damage("2&1&1&" + std::string(8, '\1'), parser(decode_colmap_array));
}

TEST(DamagedWorkspaces, TruncatedBinariesAreErrors) {
  const auto all_cuts_fail = [](const std::string& content, const Parser& parse) {
    for (std::size_t size = 0; size < content.size(); ++size)
      EXPECT_FALSE(parse(content.substr(0, size))) << size;
  };
  all_cuts_fail(small_cameras(), parser(parse_colmap_cameras_bin));
  all_cuts_fail(small_images(), parser(parse_colmap_images_bin));
  all_cuts_fail(small_points(), parser(parse_colmap_points_bin));
}

TEST(DamagedWorkspaces, HeadersDoNotAllocate) {
  const testing::LimitedMemory limit(std::size_t{256} << 20);
  for (const char* header : {"65535&4000&3&", "65536&65536&1&", "4294967297&1&1&"})
    EXPECT_THAT(decode_colmap_array(std::string(header) + "0123", "a"), HasError()) << header;
  std::string many(64, '\0');
  many[5] = 1;
  EXPECT_THAT(parse_colmap_cameras_bin(many, "a"), HasError());
  EXPECT_THAT(parse_colmap_images_bin(many, "a"), HasError());
  EXPECT_THAT(parse_colmap_points_bin(many, "a"), HasError());
  EXPECT_THAT(parse_middlebury_par("4000000000\n", "a"), HasError());
}

}  // namespace
}  // namespace relief
