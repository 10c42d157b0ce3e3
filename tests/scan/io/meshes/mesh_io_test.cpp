#include "relief/io/mesh_io.h"

#include <cmath>
#include <cstring>
#include <string>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scan/io/files/atomic_file.h"
#include "scan/io/meshes/coloured_mesh.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/small_meshes.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::largest_distance;
using testing::TemporaryFolder;
using testing::tetrahedron;
using testing::with_attributes;

class MeshFormatWithAttributes : public ::testing::TestWithParam<std::tuple<std::string, double>> {
};
INSTANTIATE_TEST_SUITE_P(EndingAndDistance, MeshFormatWithAttributes,
                         ::testing::Combine(::testing::Values("ply", "vtp"),
                                            ::testing::Values(0.0, 1e6)),
                         testing::PrintedName());

TEST_P(MeshFormatWithAttributes, KeepsEverything) {
  const auto& [ending, distance] = GetParam();
  const TemporaryFolder folder;
  const auto path = folder / ("a." + ending);
  const TriangleMesh mesh = with_attributes(tetrahedron(Eigen::Vector3d::Constant(distance)));
  ASSERT_THAT(write_mesh(mesh, path), IsOk());
  const auto read = value_of(read_mesh(path));
  EXPECT_LT(largest_distance(mesh, read), 2e-7);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.quality, mesh.quality);
  EXPECT_EQ(read.views, mesh.views);
  EXPECT_EQ(read.source_views, mesh.source_views);
  EXPECT_EQ(read.filled, mesh.filled);
  EXPECT_EQ(read.colours, mesh.colours);
}

TEST(MeshIo, ObjAndStlKeepTheSurface) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = tetrahedron({5, 6, 7});
  for (const char* name : {"a.obj", "a.stl"}) {
    ASSERT_THAT(write_mesh(mesh, folder / name), IsOk());
    const auto read = value_of(read_mesh(folder / name));
    EXPECT_EQ(read.vertices.size(), 4u) << "equal corners are joined";
    EXPECT_EQ(read.faces.size(), 4u);
    EXPECT_NEAR(enclosed_volume(read), enclosed_volume(mesh), 1e-5);
  }
}

TEST(MeshIo, ObjWritesNormals) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_mesh(with_attributes(tetrahedron()), folder / "a.obj"), IsOk());
  EXPECT_THAT(*read_file(folder / "a.obj"), HasSubstr("vn "));
  EXPECT_THAT(read_mesh(folder / "a.obj"), IsOk());
}

TEST(MeshIo, GlbIsWellFormed) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = with_attributes(tetrahedron(Eigen::Vector3d::Constant(1e6)));
  ASSERT_THAT(write_mesh(mesh, folder / "a.glb"), IsOk());
  const std::string bytes = *read_file(folder / "a.glb");
  const auto word = [&](std::size_t at) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(4), 2u);
  EXPECT_EQ(word(8), bytes.size());
  const std::size_t json_size = word(12);
  const auto scene = nlohmann::json::parse(bytes.substr(20, json_size));
  EXPECT_EQ(word(20 + json_size), scene["buffers"][0]["byteLength"].get<std::size_t>());
  EXPECT_EQ(bytes.size(), 28 + json_size + word(20 + json_size));
  EXPECT_EQ(scene["accessors"][0]["count"], 12);
  EXPECT_EQ(scene["nodes"][0]["translation"][0], 1e6);
}

TEST(MeshIo, GlbHasColoursAndTheExpectedError) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = with_attributes(tetrahedron());
  ASSERT_THAT(write_mesh(mesh, folder / "a.glb"), IsOk());
  const std::string bytes = *read_file(folder / "a.glb");
  std::uint32_t json_size;
  std::memcpy(&json_size, bytes.data() + 12, 4);
  const auto scene = nlohmann::json::parse(bytes.substr(20, json_size));
  const auto& attributes = scene["meshes"][0]["primitives"][0]["attributes"];
  const auto values_of = [&](const char* name) {
    const auto& accessor = scene["accessors"][attributes[name].get<std::size_t>()];
    EXPECT_EQ(accessor["count"], mesh.vertices.size());
    const auto& view = scene["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    return bytes.data() + 28 + json_size + view.value("byteOffset", std::size_t{0});
  };
  float error;
  std::memcpy(&error, values_of("_EXPECTED_ERROR") + 4, 4);
  EXPECT_EQ(error, mesh.quality[1]);
  // sRGB to linear, by the formula for larger values.
  std::uint16_t red;
  std::memcpy(&red, values_of("COLOR_0") + 8, 2);
  const double srgb = mesh.colours[1][0] / 255.0;
  EXPECT_NEAR(red / 65535.0, srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4),
              1e-5);
}

TEST(MeshIo, ObjHasColours) {
  const TemporaryFolder folder;
  TriangleMesh mesh = tetrahedron();
  mesh.colours.assign(mesh.vertices.size(), Colour{255, 0, 51});
  ASSERT_THAT(write_mesh(mesh, folder / "a.obj"), IsOk());
  EXPECT_THAT(*read_file(folder / "a.obj"), HasSubstr(" 1 0 0.2\n"));
  EXPECT_EQ(read_mesh(folder / "a.obj")->colours, mesh.colours);
  folder.write("weights.obj", "v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n");
  EXPECT_TRUE(read_mesh(folder / "weights.obj")->colours.empty());
  folder.write("some.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_TRUE(read_mesh(folder / "some.obj")->colours.empty()) << "not of every vertex";
}

TEST(MeshIo, StlIsNotWrittenWhereItsNumbersAreTooShort) {
  const TemporaryFolder folder;
  TriangleMesh mesh = tetrahedron();
  for (auto& vertex : mesh.vertices) vertex += Eigen::Vector3d::Constant(1e9);
  EXPECT_THAT(write_mesh(mesh, folder / "far.stl"), HasError("far.stl", "far from the origin"));
  EXPECT_FALSE(std::filesystem::exists(folder / "far.stl"));
  EXPECT_THAT(write_mesh(mesh, folder / "far.obj"), IsOk());
}

TEST(MeshIo, ThreeMfIsAnArchiveWithTheModel) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = with_attributes(tetrahedron());
  ASSERT_THAT(write_mesh(mesh, folder / "a.3mf"), IsOk());
  const std::string bytes = *read_file(folder / "a.3mf");
  EXPECT_EQ(bytes.substr(0, 4), std::string("PK\x03\x04"));
  for (const char* name : {"[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"})
    EXPECT_THAT(bytes, HasSubstr(name));
  ASSERT_THAT(write_mesh(mesh, folder / "b.3mf"), IsOk());
  EXPECT_EQ(*read_file(folder / "b.3mf"), bytes);
}

TEST(MeshIo, VtpHoldsTheAttributes) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_mesh(with_attributes(tetrahedron()), folder / "a.vtp"), IsOk());
  const std::string text = *read_file(folder / "a.vtp");
  for (const char* name :
       {"normals", "quality", "views", "source_view", "filled", "RGB", "NumberOfPolys=\"4\""})
    EXPECT_THAT(text, HasSubstr(name));
}

std::string ascii_vtp(const std::string& points, const std::string& cells,
                      const std::string& offsets = "4") {
  return "<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"><PolyData>"
         "<Piece " +
         points +
         "><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
         "format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points><Polys><DataArray "
         "type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" +
         cells + "</DataArray><DataArray type=\"Float64\" Name=\"offsets\" format=\"ascii\">" +
         offsets + "</DataArray></Polys></Piece></PolyData></VTKFile>";
}

TEST(MeshIo, VtpPolygonsBecomeFans) {
  const TemporaryFolder folder;
  const auto read = value_of(read_mesh(
      folder.write("a.vtp", ascii_vtp("NumberOfPoints=\"4\" NumberOfPolys=\"1\"", "0 1 2 3"))));
  EXPECT_EQ(read.faces, (PagedVector<TriangleMesh::Face>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(MeshIo, NamesWhatIsWrongWithAVtp) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& content) {
    return read_mesh(folder.write("a.vtp", content));
  };
  const std::string sizes = "NumberOfPoints=\"4\" NumberOfPolys=\"1\"";
  EXPECT_THAT(read(ascii_vtp(sizes, "0 1 2 4")), HasError("a.vtp: cell 0: vertex index 4 of 4"));
  EXPECT_THAT(read(ascii_vtp("NumberOfPoints=\"4000000000\"", "0 1 2 3")),
              HasError("more than the file can hold"));
  EXPECT_THAT(read(ascii_vtp(sizes, "0 1 2")), HasError("'connectivity': 3 numbers, not 4"));
  EXPECT_THAT(read(ascii_vtp("NumberOfPoints=\"4\" NumberOfPolys=\"3\"", "0 1 2", "5 nan 3")),
              HasError("the offsets of its cells are damaged"));
  EXPECT_THAT(read("<VTKFile type=\"ImageData\"></VTKFile>"), HasError("without PolyData"));
  EXPECT_THAT(read("<VTKFile compressor=\"vtkLZ4DataCompressor\"></VTKFile>"), HasError("zlib"));
  EXPECT_THAT(read("solid a"), HasError("XML"));
  std::string deep;
  for (int k = 0; k < 300000; ++k) deep += "<a>";
  EXPECT_THAT(read(deep), HasError("tags"));
}

// VTK's own decoder believes them, and crashes.
TEST(MeshIo, VtpHoldsCompressedSizesAgainstTheFile) {
  const TemporaryFolder folder;
  ASSERT_THAT(write_mesh(with_attributes(tetrahedron()), folder / "a.vtp"), IsOk());
  const std::string content = *read_file(folder / "a.vtp");
  const std::size_t data = content.find('_', content.find("<AppendedData")) + 1;
  for (const std::size_t size : {0u, 2u, 3u}) {
    std::string changed = content;
    changed.replace(data + 4 * size, 4, "\xff\xff\xff\x7f");
    EXPECT_THAT(read_mesh(folder.write("a.vtp", changed)),
                HasError("a.vtp: damaged VTP: array 'normals'"));
  }
}

TEST(MeshIo, PolygonsBecomeFans) {
  const TemporaryFolder folder;
  const auto read = value_of(read_mesh(folder.write(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 "
      "0\n0.5 1.5 0\n0 1 0\n5 0 1 2 3 4\n")));
  EXPECT_EQ(read.faces.size(), 3u);
  EXPECT_NEAR(surface_area(read), 1.25, 1e-12);
}

TEST(MeshIo, ErrorsNameFileAndPlace) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& vertex, const std::string& face) {
    return read_mesh(folder.write(
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n" +
            vertex + "\n1 0 0\n1 1 0\n" + face + "\n"));
  };
  EXPECT_THAT(error("0 0 0", "3 0 1 3"), HasError("face 0: vertex index 3"));
  EXPECT_THAT(error("0 0 0", "3 0 -1 2"), HasError("vertex index -1"));
  EXPECT_THAT(error("0 0 0", "2 0 1"), HasError("2 corners"));
  EXPECT_THAT(error("0 nan 0", "3 0 1 2"), HasError("vertex 0"));
  EXPECT_THAT(read_mesh(folder / "missing.ply"), HasError());
  EXPECT_THAT(read_mesh(folder / "missing.obj"), HasError());
  EXPECT_THAT(read_mesh(folder / "missing.stl"), HasError());
  EXPECT_THAT(read_mesh(folder.write("empty.obj", "")), HasError());
  EXPECT_THAT(read_mesh(folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nf 1 2 7\n")), HasError());
  EXPECT_THAT(read_mesh(folder.write("a.xyz", "")), HasError());
}

TEST(MeshIo, WritingNeedsAKnownEndingAndAFolder) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_mesh(tetrahedron(), folder / "a.xyz"), HasError());
  EXPECT_THAT(write_mesh(tetrahedron(), folder / "missing/a.ply"),
              HasError(ErrorKind::kCannotWrite));
  EXPECT_TRUE(is_mesh_path("A.PLY"));
  EXPECT_FALSE(is_mesh_path("scan.json"));
}

TEST(ColouredMesh, KeepsTheMeshAndSaysWhatColoursMean) {
  const TemporaryFolder folder;
  const TriangleMesh mesh = with_attributes(tetrahedron());
  const auto file = folder.path() / "mesh.ply";
  const std::vector<Colour> colours{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {1, 2, 3}};
  ASSERT_TRUE(write_coloured_mesh(mesh, colours, "red is far", file));
  const auto text = value_of(read_file(file));
  EXPECT_THAT(text, HasSubstr("\ncomment red is far\n"));
  EXPECT_THAT(text, HasSubstr("property uchar red\nproperty uchar green\nproperty uchar blue\n"));
  const auto back = value_of(read_mesh(file));
  EXPECT_EQ(back.faces, mesh.faces);
  EXPECT_EQ(back.quality, mesh.quality);
  EXPECT_EQ(back.colours[3], (Colour{1, 2, 3})) << "instead of the mesh's own";
  EXPECT_LT(largest_distance(back, mesh), 1e-6);
}

}  // namespace
}  // namespace relief
