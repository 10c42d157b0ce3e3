#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/project/view_spec.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

const std::string kCamera =
    R"("camera":{"model":"pinhole","width":6,"height":4,"fx":9,"fy":8,"cx":3,"cy":2})";
const std::string kDepth = R"("depth":{"file":"a.png","scale":0.5})";

std::string document(const std::string& view) {
  return R"({"format":"relief-scan","version":1,"unit":"m","views":[)" + view + "]}";
}

auto parse(const std::string& text) { return parse_scan_json(text, "data/scan.json"); }

// Every error names the file.
auto IsRefused(const std::string& message) {
  return HasError(ErrorKind::kBadInput, "data/scan.json", message);
}

auto parse_view(const std::string& members) {
  return parse(document(R"({"name":"v0",)" + members + "}"));
}

TEST(ScanJson, ReadsAView) {
  const auto spec = value_of(
      parse(document(R"({"name":"v0",)" + kDepth + "," + kCamera +
                     R"(,"normals":{"file":"sub/n.png","axes":"opengl"},"mask":{"file":"/m.png"},
                  "world_from_view":[[0,-1,0,1],[1,0,0,2],[0,0,1,3],[0,0,0,1]]})")));
  EXPECT_EQ(spec.unit, "m");
  const ViewSpec& view = spec.views.at(0);
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
  EXPECT_THAT(parse_view(kDepth + "," + kCamera + R"(,"colour":1)"),
              IsRefused("views[0].colour: unknown key"));
  EXPECT_THAT(
      parse_view(kDepth + R"(,"camera":{"model":"pinhole","fx":9,"fy":8,"cx":3,"cy":2,"fz":1})"),
      IsRefused("views[0].camera.fz: unknown key"));
  EXPECT_THAT(parse(R"({"format":"relief-scan","version":1,"views":[{"name":"a","grid":)"
                    R"({"file":"a.ply"}}],"author":"x"})"),
              IsRefused("author: unknown key"));
}

TEST(ScanJson, FillsTheIntrinsicsOfADraft) {
  const std::string draft =
      document(R"({"name":"v0",)" + kDepth +
               R"(,"camera":{"model":"pinhole","fx":0,"fy":0,"cx":0,"cy":0}})");
  EXPECT_THAT(parse(draft), IsRefused("views[0].camera.fx: is 0"));
  EXPECT_THAT(parse(draft), IsRefused("--intrinsics"));
  const PinholeIntrinsics given{528.0, 527.0, 320.5, 240.25};
  const auto spec = value_of(parse_scan_json(draft, "scan.json", given));
  EXPECT_EQ(spec.views[0].camera->intrinsics.fy, 527.0);
  EXPECT_EQ(spec.views[0].camera->intrinsics.cx, 320.5);
  const std::string full = document(R"({"name":"v0",)" + kDepth + "," + kCamera + "}");
  EXPECT_EQ(value_of(parse_scan_json(full, "scan.json", given)).views[0].camera->intrinsics.fx, 9);
}

TEST(ScanJson, NamesLineAndColumnOfASyntaxError) {
  EXPECT_THAT(parse("{\n  \"format\": oops\n}"), IsRefused("data/scan.json:2:13"));
  EXPECT_THAT(parse(""), IsRefused("data/scan.json:1:1"));
}

TEST(ScanJson, RefusesOtherFormatsAndVersions) {
  EXPECT_THAT(parse(R"({"format":"relief-scan","version":2,"views":[]})"), IsRefused("version: 2"));
  EXPECT_THAT(parse(R"({"format":"other","version":1,"views":[]})"), IsRefused("format"));
  EXPECT_THAT(parse(R"({"format":"relief-scan","version":1,"views":[]})"), IsRefused("views"));
  EXPECT_THAT(parse("[]"), IsRefused("expected an object"));
}

TEST(ScanJson, AViewNeedsDepthOrGridAndACameraForDepth) {
  EXPECT_THAT(parse_view(kCamera), IsRefused("either depth or grid"));
  EXPECT_THAT(parse_view(kDepth + R"(,"grid":{"file":"g.ply"},)" + kCamera),
              IsRefused("either depth or grid"));
  EXPECT_THAT(parse_view(kDepth), IsRefused("views[0].camera: missing"));
  EXPECT_THAT(parse_view(kDepth + R"(,"camera":{"model":"orthographic","view_direction":[0,0,1]})"),
              IsRefused("views[0].camera.origin"));
}

TEST(ScanJson, RefusesCamerasThatCannotBe) {
  const auto camera = [](const std::string& fx) {
    return kDepth + R"(,"camera":{"model":"pinhole","fx":)" + fx + R"(,"fy":8,"cx":3,"cy":2})";
  };
  EXPECT_THAT(parse_view(camera("0")), IsRefused("views[0].camera.fx: is 0"));
  EXPECT_THAT(parse_view(camera("0.0")), IsRefused("must be a number other than 0"));
  EXPECT_THAT(parse_view(camera("\"9\"")), IsRefused("expected a number"));
  EXPECT_THAT(parse_view(camera("1e999")), IsRefused("data/scan.json"));
  EXPECT_THAT(parse_view(camera("null")), IsRefused("expected a number"));
  EXPECT_THAT(parse_view(R"("grid":{"file":"g.ply"},"camera":{"model":"fisheye"})"),
              IsRefused("pinhole, pinhole_gl, orthographic"));
  EXPECT_THAT(parse_view(R"("grid":{"file":"g.ply"},
                            "camera":{"model":"orthographic","view_direction":[0,0,0]})"),
              IsRefused("no length"));
}

TEST(ScanJson, RefusesAPoseThatIsNoRigidMotion) {
  const auto pose = [](const std::string& rows) {
    return kDepth + "," + kCamera + R"(,"world_from_view":)" + rows;
  };
  EXPECT_THAT(parse_view(pose("[[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]")),
              IsRefused("views[0].world_from_view (view v0) is not a rigid motion"));
  EXPECT_THAT(parse_view(pose("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]")),
              IsRefused("reflection"));
  EXPECT_THAT(parse_view(pose("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]")), IsRefused("four rows"));
  EXPECT_THAT(parse_view(pose("[[1,0,0,0],[0,1,0],[0,0,1,0],[0,0,0,1]]")),
              IsRefused("world_from_view[1]"));
  EXPECT_THAT(parse_view(kDepth + "," + kCamera + R"(,"pose_is":"known")"), IsRefused("pose_is"));
}

TEST(ScanJson, RefusesTwoViewsOfOneName) {
  const std::string view = R"({"name":"same","grid":{"file":"g.ply"}})";
  EXPECT_THAT(parse(document(view + "," + view)), IsRefused("views[1].name"));
}

TEST(ScanJson, RefusesWrongTypes) {
  EXPECT_THAT(parse(document("5")), IsRefused("views[0]: expected an object"));
  EXPECT_THAT(parse(document(R"({"name":7})")), IsRefused("views[0].name: expected a text"));
  EXPECT_THAT(parse_view(R"("grid":"g.ply")"), IsRefused("views[0].grid: expected an object"));
  EXPECT_THAT(parse_view(R"("grid":{"file":""})"), IsRefused("empty"));
}

TEST(ScanJson, NamesTheKeyAndViewOfNumbersOfPython) {
  const auto parse = [](const std::string& pose, const std::string& fx) {
    return parse_scan_json(
        R"({"format": "relief-scan", "version": 1, // of NaN "quotes
            "unit": "NaN \" Infinity", "views": [{"name": "front", "depth": {"file": "a.png"},
            "camera": {"model": "pinhole", "fx": )" +
            fx + R"(, "fy": 1, "cx": 0, "cy": 0}, "world_from_view": [[)" + pose +
            ", 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}",
        "scan.json");
  };
  EXPECT_THAT(parse("1", "1"), IsOk());
  EXPECT_THAT(parse("NaN", "1"), HasError("scan.json: view front: "
                                          "views[0].world_from_view[0][0]: is NaN, as Python"));
  EXPECT_THAT(parse("1", "-Infinity"), HasError("views[0].camera.fx: is -Infinity"));
  EXPECT_THAT(parse("NaN", "nul"), HasError("not valid JSON here"));
}

}  // namespace
}  // namespace relief
