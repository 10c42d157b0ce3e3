#include "relief/fusion/tile_mesh.h"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <random>
#include <stop_token>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/mesh_check.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

struct Tiles {
  std::vector<MeshTile> tree;
  std::map<std::size_t, TriangleMesh> meshes;
};

Tiles tiles_of(const TriangleMesh& mesh, std::size_t faces, const Context& context = {}) {
  Tiles tiles;
  std::mutex mutex;
  const auto store = [&](std::size_t tile, const TriangleMesh& part) -> Result<void> {
    const std::lock_guard lock(mutex);
    tiles.meshes[tile] = part;
    return {};
  };
  tiles.tree = value_of(tile_mesh(mesh, {.faces = faces}, store, context));
  return tiles;
}

// Tiles side by side, their common vertices found by their coordinates alone, as a viewer shows
// them.
TriangleMesh joined(const Tiles& tiles, const std::vector<std::size_t>& chosen) {
  TriangleMesh all;
  std::map<std::array<double, 3>, std::uint32_t> index;
  for (const std::size_t tile : chosen) {
    const TriangleMesh& part = tiles.meshes.at(tile);
    for (TriangleMesh::Face face : part.faces) {
      for (std::uint32_t& v : face) {
        const Eigen::Vector3d& place = part.vertices[v];
        const auto [found, added] = index.try_emplace(
            {place.x(), place.y(), place.z()}, static_cast<std::uint32_t>(all.vertices.size()));
        if (added) all.vertices.push_back(place);
        v = found->second;
      }
      all.faces.push_back(face);
    }
  }
  return all;
}

std::vector<std::size_t> leaves(const Tiles& tiles) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < tiles.tree.size(); ++i)
    if (tiles.tree[i].children.empty()) found.push_back(i);
  return found;
}

// Tiles that show each part once, each tile refined or not by chance.
void choose(const Tiles& tiles, std::size_t tile, std::mt19937& random,
            std::vector<std::size_t>& chosen) {
  const auto& children = tiles.tree[tile].children;
  if (children.empty() || random() % 3 == 0)
    chosen.push_back(tile);
  else
    for (const std::size_t child : children) choose(tiles, child, random, chosen);
}

TEST(TileMesh, TheMostDetailedTilesTogetherAreTheMesh) {
  const Tiles tiles = tiles_of(testing::torus_mesh(), 1000);
  ASSERT_GT(tiles.tree.size(), 20u);
  const TriangleMesh all = joined(tiles, leaves(tiles));
  EXPECT_EQ(all.vertices.size(), testing::torus_mesh().vertices.size());
  EXPECT_EQ(all.faces.size(), testing::torus_mesh().faces.size());
  EXPECT_NEAR(enclosed_volume(all), enclosed_volume(testing::torus_mesh()), 1e-6);
}

TEST(TileMesh, AnyChoiceOfTilesIsClosedWithoutCracks) {
  const Tiles tiles = tiles_of(testing::torus_mesh(), 1000);
  std::mt19937 random(7);
  for (int i = 0; i < 20; ++i) {
    std::vector<std::size_t> chosen;
    choose(tiles, 0, random, chosen);
    const TriangleMesh all = joined(tiles, chosen);
    const MeshCheck check = check_mesh(all);
    EXPECT_TRUE(check.watertight()) << chosen.size() << " tiles";
    EXPECT_EQ(check.genus, 1);
    EXPECT_NEAR(enclosed_volume(all) / enclosed_volume(testing::torus_mesh()), 1.0, 0.03)
        << "as decimate_mesh() leaves with 1000 faces";
  }
}

TEST(TileMesh, CoarserTilesHaveFewerFacesAndLongerEdges) {
  const Tiles tiles = tiles_of(testing::torus_mesh(), 1000);
  for (const MeshTile& tile : tiles.tree) {
    std::size_t below = 0;
    for (const std::size_t child : tile.children) {
      below += tiles.tree[child].faces;
      EXPECT_GT(tile.edge_length, 1.2 * tiles.tree[child].edge_length);
      EXPECT_TRUE(tile.box.contains(tiles.tree[child].box));
    }
    if (!tile.children.empty()) {
      EXPECT_LT(2 * tile.faces, below);
    }
  }
  EXPECT_LE(tiles.tree[0].faces, 1000u);
  EXPECT_LE(tiles.meshes.at(0).faces.size(), 1000u);
}

TEST(TileMesh, VerticesKeepTheirAttributes) {
  TriangleMesh mesh = testing::torus_mesh();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.quality[v] = static_cast<float>(mesh.vertices[v].x());
  for (const auto& [tile, part] : tiles_of(mesh, 1000).meshes) {
    ASSERT_EQ(part.quality.size(), part.vertices.size());
    ASSERT_EQ(part.normals.size(), part.vertices.size());
    ASSERT_EQ(part.filled.size(), part.vertices.size());
    for (std::size_t v = 0; v < part.vertices.size(); ++v)
      ASSERT_EQ(part.quality[v], static_cast<float>(part.vertices[v].x()));
  }
}

TEST(TileMesh, TheNumberOfThreadsChangesNothing) {
  const Tiles one = tiles_of(testing::torus_mesh(), 2000, {.threads = 1});
  const Tiles many = tiles_of(testing::torus_mesh(), 2000, {.threads = 4});
  ASSERT_EQ(one.meshes.size(), many.meshes.size());
  for (const auto& [tile, part] : one.meshes) {
    EXPECT_EQ(part.faces, many.meshes.at(tile).faces);
    EXPECT_EQ(part.vertices, many.meshes.at(tile).vertices);
  }
}

TEST(TileMesh, AMemoryLimitChangesNothing) {
  const Tiles free = tiles_of(testing::torus_mesh(), 2000);
  const Tiles limited = tiles_of(testing::torus_mesh(), 2000, {.memory = std::size_t{1} << 20});
  for (const auto& [tile, part] : free.meshes) EXPECT_EQ(part.faces, limited.meshes.at(tile).faces);
}

TEST(TileMesh, ASmallMeshIsOneTile) {
  const Tiles tiles = tiles_of(testing::torus_mesh(), 10'000'000);
  ASSERT_EQ(tiles.tree.size(), 1u);
  EXPECT_EQ(tiles.meshes.at(0).faces.size(), testing::torus_mesh().faces.size());
}

TEST(TileMesh, FacesInOnePlaceEndTheDivision) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.assign(300, {0, 1, 2});
  EXPECT_FALSE(tiles_of(mesh, 100).tree.empty());
}

TEST(TileMesh, ErrorsAreTold) {
  const StoreTile kept = [](std::size_t, const TriangleMesh&) -> Result<void> { return {}; };
  EXPECT_THAT(tile_mesh(TriangleMesh(), {}, kept), HasError(ErrorKind::kBadInput));
  EXPECT_THAT(tile_mesh(testing::torus_mesh(), {.faces = 10}, kept),
              HasError(ErrorKind::kBadInput));
  const StoreTile full = [](std::size_t, const TriangleMesh&) -> Result<void> {
    return Error{ErrorKind::kCannotWrite, "no space"};
  };
  EXPECT_THAT(tile_mesh(testing::torus_mesh(), {}, full), HasError(ErrorKind::kCannotWrite));
  std::stop_source source;
  source.request_stop();
  EXPECT_THAT(tile_mesh(testing::torus_mesh(), {}, kept, {.stop = source.get_token()}),
              HasError(ErrorKind::kInterrupted));
}

}  // namespace
}  // namespace relief::fusion
