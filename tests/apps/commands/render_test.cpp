// What `relief render` writes, of models and of views.
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scan/io/images/image_io.h"
#include "tests/support/program.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/simulated_scans.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using testing::files_below;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;

class Render : public testing::SimulatedScans<Render> {
 public:
  static std::vector<std::string> simulation() {
    return {"--views", "3", "--width", "96", "--height", "96", "--mesh-divisions", "20"};
  }

 protected:
  // Renders to out.png, and gives the picture and the report.
  std::pair<Image, json> render(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render"});
    arguments.insert(arguments.end(), {"-o", out_ / "out.png", "--json", "-q"});
    const ProgramRun run = run_relief(arguments);
    EXPECT_EQ(run.exit_status, 0) << run.standard_error;
    auto image = value_of(read_image(out_ / "out.png"));
    if (run.exit_status != 0) return {};
    return {std::move(image), json::parse(run.standard_output)["render"]};
  }

  // Renders in vain: the message.
  std::string fail(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render"});
    arguments.insert(arguments.end(), {"-o", out_ / "out.png"});
    const ProgramRun run = run_relief(arguments);
    EXPECT_EQ(run.exit_status, 2);
    EXPECT_THAT(files_below(out_.path()), IsEmpty());
    return run.standard_error;
  }

  // Of the pixels that are not white.
  static std::size_t covered(const Image& image) {
    std::size_t count = 0;
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u)
        count += image(u, v, 0) + image(u, v, 1) + image(u, v, 2) < 3 * 255 ? 1 : 0;
    return count;
  }

  const TemporaryFolder out_;
};

TEST_F(Render, AModelFillsThePicture) {
  const auto [image, report] = render({model(), "--size", "120x100"});
  EXPECT_EQ(image.width, 120);
  EXPECT_EQ(image.height, 100);
  EXPECT_GT(covered(image), 120u * 100u / 4u);
  EXPECT_EQ(report["pictures"][0]["cells"].size(), 1u);
}

TEST_F(Render, OptionsChangeThePicture) {
  const auto bytes = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {model(), "--size", "60x50"});
    render(more);
    return read_text(out_ / "out.png");
  };
  const std::vector<std::vector<std::string>> changes = {
      {"--view", "-40,10"},
      {"--view", "30,20,15"},
      {"--up", "y"},
      {"--field-of-view", "0"},
      {"--light", "60,-20"},
      {"--antialiasing", "4"},
      {"--normals", "faces"},
      {"--background", "transparent"},
      {"--style", "grazing"},
      {"--style", "accessibility"},
      {"--style", "accessibility", "--ambient-rays", "16"},
      {"--style", "accessibility", "--ambient-reach", "0.02"},
      {"--style", "accessibility", "--seed", "5"},
      {"--style", "depth"},
      {"--style", "depth", "--range", "1,2"},
      {"--style", "depth", "--no-legend"},
      {"--style", "normals"}};
  std::set<std::string> all{bytes({})};
  for (const auto& change : changes) all.insert(bytes(change));
  EXPECT_EQ(all.size(), changes.size() + 1);
}

TEST_F(Render, IsTheSameOnAnyNumberOfThreads) {
  const auto bytes = [&](const std::string& threads) {
    render({model(), "--size", "90x80", "--style", "shaded,accessibility,depth", "--threads",
            threads});
    return read_text(out_ / "out.png");
  };
  EXPECT_EQ(bytes("1"), bytes("2"));
}

TEST_F(Render, AContactSheetShowsSixSides) {
  const auto [image, report] = render({model(), "--contact-sheet", "--size", "60x50"});
  const json& cells = report["pictures"][0]["cells"];
  ASSERT_EQ(cells.size(), 6u);
  EXPECT_EQ(cells[1]["caption"], "view 90,0");
  EXPECT_GE(image.width, 3 * 60);
  EXPECT_GE(image.height, 2 * 50);
}

TEST_F(Render, DirectionsAreRowsAndStylesColumns) {
  const auto [image, report] =
      render({model(), "--view", "0,0", "--view", "90,0", "--view", "0,80", "--style",
              "shaded,depth", "--size", "60x50", "--no-legend"});
  const json& cells = report["pictures"][0]["cells"];
  ASSERT_EQ(cells.size(), 6u);
  EXPECT_EQ(cells[3]["caption"], "view 90,0, depth");
  EXPECT_EQ(cells[3]["title"], "range");
  EXPECT_LT(cells[3]["range"][0], cells[3]["range"][1]);
  EXPECT_EQ(image.width, 2 * 60 + 8);  // with a gap between pictures
  EXPECT_EQ(image.height, 3 * 50 + 2 * 8);
}

TEST_F(Render, ATurntableIsANumberedSeries) {
  const ProgramRun run = run_relief(
      {"render", model(), "-o", out_ / "turn.png", "--turntable", "3", "--size", "40x40", "-q"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(files_below(out_.path()),
              ElementsAre("turn-000.png", "turn-001.png", "turn-002.png"));
  EXPECT_NE(read_text(out_ / "turn-000.png"), read_text(out_ / "turn-001.png"));
}

TEST_F(Render, DistancesOfAMeshToItselfAreZero) {
  const auto [image, report] =
      render({model(), "--style", "distance", "--truth", model(), "--size", "60x50"});
  const json& cell = report["pictures"][0]["cells"][0];
  EXPECT_EQ(cell["title"], "distance");
  EXPECT_EQ(cell["range"], json({-1.0, 1.0}));
  EXPECT_THAT(read_text(out_ / "out.png"), HasSubstr("distance: -1 to 1"));
}

TEST_F(Render, ViewsAreShownFromTheirOwnCameras) {
  const auto [image, report] = render({scan(), "--size", "80x80"});
  const json& cells = report["pictures"][0]["cells"];
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(cells[0]["caption"], "v000");
  EXPECT_GT(covered(image), 3u * 80u * 80u / 4u);
}

TEST_F(Render, ViewsOfTwoProjectsStandSideBySide) {
  const auto [image, report] =
      render({scan(), truth(), "--only", "v001", "--style", "shaded,normals", "--size", "80x80"});
  const json& cells = report["pictures"][0]["cells"];
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_THAT(cells[1]["caption"].get<std::string>(), HasSubstr("normals"));
  EXPECT_THAT(cells[2]["caption"].get<std::string>(), HasSubstr("v001, truth"));
}

TEST_F(Render, TheRangesOfAViewHaveItsUnit) {
  const auto [image, report] = render({scan(), "--style", "depth", "--only", "v000"});
  EXPECT_EQ(report["pictures"][0]["cells"][0]["title"], "range [mm]");
}

TEST_F(Render, SaysWhichFileLacksWhat) {
  const std::string message = fail({model(), "--style", "expected_error"});
  EXPECT_THAT(message, HasSubstr("model.ply"));
  EXPECT_THAT(message, HasSubstr("expected error (quality)"));
  EXPECT_THAT(message, HasSubstr("relief merge"));
  EXPECT_THAT(fail({scan(), "--style", "expected_error"}), HasSubstr("view v000"));
  EXPECT_THAT(fail({model(), "--style", "distance"}), HasSubstr("--truth"));
}

TEST_F(Render, WrongUseSaysWhatToDo) {
  EXPECT_THAT(fail({model(), "--view", "10"}), HasSubstr("10 has 1 numbers; give 2 or 3"));
  EXPECT_THAT(fail({model(), "--view", "10,95"}), HasSubstr("-90 to 90"));
  EXPECT_THAT(fail({model(), "--view", "10,up"}), HasSubstr("'up' in 10,up is not a number"));
  EXPECT_THAT(fail({model(), "--size", "100"}), HasSubstr("WIDTHxHEIGHT"));
  EXPECT_THAT(fail({model(), "--size", "100x99999"}), HasSubstr("16384"));
  EXPECT_THAT(fail({model(), "--range", "2,1"}), HasSubstr("the smaller one"));
  EXPECT_THAT(fail({model(), "--style", "shiny"}), HasSubstr("shiny"));
  EXPECT_THAT(fail({model(), "--only", "v000"}), HasSubstr("is a mesh"));
  EXPECT_THAT(fail({model(), scan()}), HasSubstr("of one kind"));
  EXPECT_THAT(fail({scan(), "--view", "0,0"}), HasSubstr("--view is for models"));
  EXPECT_THAT(fail({scan(), "--up", "y"}), HasSubstr("--up is for models"));
  EXPECT_THAT(fail({model(), "--truth", model()}), HasSubstr("add --style distance"));
  EXPECT_THAT(fail({scan(), "--only", "v009"}), HasSubstr("no view v009"));
  const ProgramRun run = run_relief({"render", model(), "-o", out_ / "out.jpg"});
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_THAT(run.standard_error, HasSubstr("end the name in .png"));
}

}  // namespace
}  // namespace relief
