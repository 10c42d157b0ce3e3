// What `relief evaluate` writes: figures, coloured meshes, plots.
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/scenes/simulated_scans.h"

namespace relief {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::TemporaryFolder;

class Evaluate : public testing::SimulatedScans<Evaluate> {
 public:
  static std::vector<std::string> simulation() {
    return {"--views", "2", "--width", "128", "--height", "128", "--mesh-divisions", "20"};
  }

 protected:
  static bool have_gnuplot() { return std::system("gnuplot --version > /dev/null 2>&1") == 0; }

  const TemporaryFolder out_;
};

TEST_F(Evaluate, ReportsSpectraOfViews) {
  const ProgramRun run = run_relief({"evaluate", scan(), "--truth", truth(), "--json", "-q"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const json spectra = json::parse(run.standard_output)["evaluate"]["spectra"];
  for (const char* what : {"depth", "geometry_normals", "map_normals"}) {
    const json& spectrum = spectra[what];
    EXPECT_GT(spectrum["density"].size(), 4u) << what;
    EXPECT_EQ(spectrum["density"].size(), spectrum["frequency"].size());
    EXPECT_GT(spectrum["variance"].get<double>(), 0.0);
  }
  EXPECT_GT(spectra["spacing"].get<double>(), 0.0);
}

TEST_F(Evaluate, PlotsViews) {
  if (!have_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const std::string plots = out_ / "plots";
  const ProgramRun run =
      run_relief({"evaluate", scan(), "--truth", truth(), "--plots", plots, "-q"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(read_text(out_ / "plots/spectra.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(read_text(out_ / "plots/spectrum-depth.tsv"), HasSubstr("frequency\tdensity"));
  int images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(plots))
    images += entry.path().extension() == ".png" && entry.file_size() > 1000;
  EXPECT_EQ(images, 2 * 3);
}

TEST_F(Evaluate, PlotsAndColoursMeshes) {
  if (!have_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const ProgramRun run = run_relief({"evaluate", model(), "--truth", model(), "-o", out_ / "errors",
                                     "--plots", out_ / "plots", "--thresholds", "0.5", "1", "-q"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(read_text(out_ / "plots/distances.svg"), HasSubstr("</svg>"));
  for (const char* file : {"errors/errors.ply", "errors/completeness.ply"})
    EXPECT_THAT(read_text(out_ / file),
                HasSubstr("comment quality: distance to the other surface"));
  const json report = json::parse(read_text(out_ / "errors/report.json"))["evaluate"];
  EXPECT_EQ(report["f_score"].size(), 2u);
  EXPECT_EQ(report["topology"]["self_intersections"], 0);
  EXPECT_GT(report["colour_scale"].get<double>(), 0.0);
}

TEST_F(Evaluate, FitsTheResultToTheTruthWhenAsked) {
  const ProgramRun run =
      run_relief({"evaluate", model(), "--truth", model(), "--align", "--json", "-q"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  const json report = json::parse(run.standard_output)["evaluate"];
  EXPECT_TRUE(report["alignment"]["converged"]);
  EXPECT_LT(report["accuracy"]["max"].get<double>(), 1e-6);
}

TEST_F(Evaluate, TakesTrajectoriesForTruePoses) {
  for (const std::string file : {"truth.tum", "truth.log"}) {
    ASSERT_EQ(run_relief({"convert", truth(), "-o", out_ / file, "-q"}).exit_status, 0);
    const ProgramRun run = run_relief({"evaluate", scan(), "--truth", out_ / file, "--json", "-q"});
    ASSERT_EQ(run.exit_status, 0) << run.standard_error;
    const json poses = json::parse(run.standard_output)["evaluate"]["poses"];
    EXPECT_EQ(poses["views"].size(), 2u) << file;
  }
}

TEST_F(Evaluate, SaysWhatIsMissingWithoutGnuplot) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", out_.path().c_str(), 1);
  const ProgramRun run = run_relief({"evaluate", model(), "--truth", model(), "--plots",
                                     out_ / "plots", "--report", out_ / "report.json", "-q"});
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(run.exit_status, 2);
  EXPECT_THAT(run.standard_error, HasSubstr("gnuplot-nox"));
  EXPECT_TRUE(std::filesystem::exists(out_ / "report.json"));  // the figures come first
  EXPECT_TRUE(std::filesystem::exists(out_ / "plots/accuracy.tsv"));
}

}  // namespace
}  // namespace relief
