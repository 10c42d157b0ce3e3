#include "relief/io/tileset.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using nlohmann::json;

TriangleMesh triangle(double x) {
  TriangleMesh mesh;
  mesh.vertices = {{x, 0, 0}, {x + 1, 0, 4}, {x, 2, 0}};
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

std::vector<MeshTile> two_levels() {
  std::vector<MeshTile> tiles(3);
  tiles[1].box = bounding_box(triangle(0.0));
  tiles[2].box = bounding_box(triangle(10.0));
  tiles[0].box = tiles[1].box.merged(tiles[2].box);
  tiles[0].edge_length = 2.0;
  tiles[1].edge_length = tiles[2].edge_length = 1.0;
  tiles[0].children = {1, 2};
  return tiles;
}

json read_json(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return json::parse(stream);
}

void write_all(const TilesetWriter& writer) {
  ASSERT_THAT(writer.begin(), IsOk());
  for (std::size_t i = 0; i < 3; ++i)
    ASSERT_THAT(writer.write_tile(i, triangle(5.0 * static_cast<double>(i))), IsOk());
  ASSERT_THAT(writer.finish(two_levels(), 0.001), IsOk());
}

// The corner of a box of a tile that is farthest along all axes, where the transform puts it.
Eigen::Vector3d largest_corner(const json& transform, const json& box) {
  Eigen::Matrix4d world;
  for (int i = 0; i < 16; ++i) world(i % 4, i / 4) = transform[static_cast<std::size_t>(i)];
  Eigen::AlignedBox3d all;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d place(box[0], box[1], box[2]);
    for (std::size_t k = 0; k < 3; ++k)
      place += (corner >> k & 1 ? 1.0 : -1.0) *
               Eigen::Vector3d(box[3 + 3 * k], box[4 + 3 * k], box[5 + 3 * k]);
    all.extend((world * place.homogeneous()).head<3>().eval());
  }
  return all.max();
}

TEST(Tileset, TellsTheTreeInMetresAndTheAxesOfTheMesh) {
  const testing::TemporaryFolder folder;
  write_all(TilesetWriter(folder.path() / "old statue.json"));
  const json tileset = read_json(folder.path() / "old statue.json");
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  const json& root = tileset["root"];
  EXPECT_EQ(root["refine"], "REPLACE");
  EXPECT_EQ(root["content"]["uri"], "old%20statue_tiles/0.glb");
  ASSERT_EQ(root["children"].size(), 2u);
  EXPECT_EQ(root["children"][1]["content"]["uri"], "old%20statue_tiles/2.glb");
  EXPECT_EQ(root["geometricError"], 16.0);
  EXPECT_EQ(root["children"][0]["geometricError"], 0.0);
  EXPECT_TRUE(largest_corner(root["transform"], root["boundingVolume"]["box"])
                  .isApprox(Eigen::Vector3d(0.011, 0.002, 0.004)));
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(
        std::filesystem::exists(folder.path() / "old statue_tiles" / (std::to_string(i) + ".glb")));
}

TEST(Tileset, AnOlderSetLeavesNothingBehind) {
  const testing::TemporaryFolder folder;
  const TilesetWriter writer(folder.path() / "statue.json");
  write_all(writer);
  ASSERT_THAT(writer.begin(), IsOk());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "statue.json"))
      << "while its tiles are written anew";
  ASSERT_THAT(writer.write_tile(0, triangle(0.0)), IsOk());
  std::vector<MeshTile> one = two_levels();
  one.resize(1);
  one[0].children.clear();
  ASSERT_THAT(writer.finish(one, 1.0), IsOk());
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "statue_tiles/0.glb"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "statue_tiles/1.glb"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "statue_tiles/2.glb"));
}

TEST(Tileset, AProjectOfThatNameIsNotLost) {
  const testing::TemporaryFolder folder;
  const auto project = folder.write("scan.json", R"({"format": "relief-scan", "views": []})");
  EXPECT_THAT(TilesetWriter(project).begin(), HasError(ErrorKind::kCannotWrite));
  EXPECT_TRUE(std::filesystem::exists(project));
}

TEST(Tileset, AFolderThatCannotBeMadeIsAnError) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path() / "statue_tiles") << "a file";
  EXPECT_THAT(TilesetWriter(folder.path() / "statue.json").begin(),
              HasError(ErrorKind::kCannotWrite));
}

}  // namespace
}  // namespace relief
