#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/project/view_spec.h"

namespace relief {
namespace {

using ::testing::HasSubstr;

const std::string kCamera =
    R"("camera":{"model":"pinhole","width":6,"height":4,"fx":9,"fy":8,"cx":3,"cy":2})";
const std::string kDepth = R"("depth":{"file":"a.png","scale":0.5})";

std::string document(const std::string& view) {
  return R"({"format":"relief-scan","version":1,"unit":"m","views":[)" + view + "]}";
}

std::string error_of(const std::string& text) {
  const auto spec = parse_scan_json(text, "data/scan.json");
  if (spec.ok()) return "no error";
  EXPECT_EQ(spec.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(spec.error().message, HasSubstr("data/scan.json"));
  return spec.error().message;
}

std::string view_error(const std::string& members) {
  return error_of(document(R"({"name":"v0",)" + members + "}"));
}

TEST(ScanJson, ReadsAView) {
  const auto spec = parse_scan_json(
      document(R"({"name":"v0",)" + kDepth + "," + kCamera +
               R"(,"normals":{"file":"sub/n.png","axes":"opengl"},"mask":{"file":"/m.png"},
                  "world_from_view":[[0,-1,0,1],[1,0,0,2],[0,0,1,3],[0,0,0,1]]})"),
      "data/scan.json");
  ASSERT_TRUE(spec.ok()) << spec.error().message;
  EXPECT_EQ(spec->unit, "m");
  const ViewSpec& view = spec->views.at(0);
  EXPECT_EQ(view.depth->file, "data/a.png");
  EXPECT_EQ(view.depth->scale, 0.5);
  EXPECT_FALSE(view.depth->along_ray);
  EXPECT_EQ(view.normals->file, "data/sub/n.png");
  EXPECT_EQ(view.normals->axes, NormalAxes::kOpengl);
  EXPECT_FALSE(view.normals->space.has_value());
  EXPECT_EQ(view.mask->file, "/m.png");
  EXPECT_EQ(view.pose, PoseKind::kGuess);
  EXPECT_EQ(view.world_from_view.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(view.camera->intrinsics.fy, 8);
}

TEST(ScanJson, NamesAnUnknownKeyWithItsPlace) {
  EXPECT_THAT(view_error(kDepth + "," + kCamera + R"(,"colour":1)"),
              HasSubstr("views[0].colour: unknown key"));
  EXPECT_THAT(
      view_error(kDepth + R"(,"camera":{"model":"pinhole","fx":9,"fy":8,"cx":3,"cy":2,"fz":1})"),
      HasSubstr("views[0].camera.fz: unknown key"));
  EXPECT_THAT(error_of(R"({"format":"relief-scan","version":1,"views":[{"name":"a","grid":)"
                       R"({"file":"a.ply"}}],"author":"x"})"),
              HasSubstr("author: unknown key"));
}

TEST(ScanJson, NamesLineAndColumnOfASyntaxError) {
  EXPECT_THAT(error_of("{\n  \"format\": oops\n}"), HasSubstr("data/scan.json:2:13"));
  EXPECT_THAT(error_of(""), HasSubstr("data/scan.json:1:1"));
}

TEST(ScanJson, RefusesOtherFormatsAndVersions) {
  EXPECT_THAT(error_of(R"({"format":"relief-scan","version":2,"views":[]})"),
              HasSubstr("version: 2"));
  EXPECT_THAT(error_of(R"({"format":"other","version":1,"views":[]})"), HasSubstr("format"));
  EXPECT_THAT(error_of(R"({"format":"relief-scan","version":1,"views":[]})"), HasSubstr("views"));
  EXPECT_THAT(error_of("[]"), HasSubstr("expected an object"));
}

TEST(ScanJson, AViewNeedsDepthOrGridAndACameraForDepth) {
  EXPECT_THAT(view_error(kCamera), HasSubstr("either depth or grid"));
  EXPECT_THAT(view_error(kDepth + R"(,"grid":{"file":"g.ply"},)" + kCamera),
              HasSubstr("either depth or grid"));
  EXPECT_THAT(view_error(kDepth), HasSubstr("views[0].camera: missing"));
  EXPECT_THAT(view_error(kDepth + R"(,"camera":{"model":"orthographic","view_direction":[0,0,1]})"),
              HasSubstr("views[0].camera.origin"));
}

TEST(ScanJson, RefusesCamerasThatCannotBe) {
  const auto camera = [](const std::string& fx) {
    return kDepth + R"(,"camera":{"model":"pinhole","fx":)" + fx + R"(,"fy":8,"cx":3,"cy":2})";
  };
  EXPECT_THAT(view_error(camera("0")), HasSubstr("views[0].camera.fx: is 0"));
  EXPECT_THAT(view_error(camera("0.0")), HasSubstr("must be a number other than 0"));
  EXPECT_THAT(view_error(camera("\"9\"")), HasSubstr("expected a number"));
  EXPECT_THAT(view_error(camera("1e999")), HasSubstr("data/scan.json"));
  EXPECT_THAT(view_error(camera("null")), HasSubstr("expected a number"));
  EXPECT_THAT(view_error(R"("grid":{"file":"g.ply"},"camera":{"model":"fisheye"})"),
              HasSubstr("pinhole, pinhole_gl, orthographic"));
  EXPECT_THAT(view_error(R"("grid":{"file":"g.ply"},
                            "camera":{"model":"orthographic","view_direction":[0,0,0]})"),
              HasSubstr("no length"));
}

TEST(ScanJson, RefusesAPoseThatIsNoRigidMotion) {
  const auto pose = [](const std::string& rows) {
    return kDepth + "," + kCamera + R"(,"world_from_view":)" + rows;
  };
  EXPECT_THAT(view_error(pose("[[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]")),
              HasSubstr("views[0].world_from_view (view v0) is not a rigid motion"));
  EXPECT_THAT(view_error(pose("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]")),
              HasSubstr("reflection"));
  EXPECT_THAT(view_error(pose("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]")), HasSubstr("four rows"));
  EXPECT_THAT(view_error(pose("[[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]")),
              HasSubstr("world_from_view[1]"));
  EXPECT_THAT(view_error(kDepth + "," + kCamera + R"(,"pose_is":"known")"), HasSubstr("pose_is"));
}

TEST(ScanJson, RefusesTwoViewsOfOneName) {
  const std::string view = R"({"name":"same","grid":{"file":"g.ply"}})";
  EXPECT_THAT(error_of(document(view + "," + view)), HasSubstr("views[1].name"));
}

TEST(ScanJson, RefusesWrongTypes) {
  EXPECT_THAT(error_of(document("5")), HasSubstr("views[0]: expected an object"));
  EXPECT_THAT(error_of(document(R"({"name":7})")), HasSubstr("views[0].name: expected a text"));
  EXPECT_THAT(view_error(R"("grid":"g.ply")"), HasSubstr("views[0].grid: expected an object"));
  EXPECT_THAT(view_error(R"("grid":{"file":""})"), HasSubstr("empty"));
}

}  // namespace
}  // namespace relief
