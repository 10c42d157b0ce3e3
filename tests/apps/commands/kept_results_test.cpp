// What `run` keeps in its folder: killed, interrupted, out of room, damaged, cleaned.
#include <csignal>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/support/program.h"

namespace relief {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::files_below;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::ProgramRun;
using testing::read_text;
using testing::run_relief;
using testing::run_relief_until;
using testing::TemporaryFolder;

constexpr int kViews = 6;
constexpr std::size_t kStages = kViews + 6;  // Two alignments, calibration, comparison, two meshes.
// The joint refinement of each alignment, two levels of the field.
constexpr std::size_t kUnits = kStages + 4;

// Exact poses, which stay when a view is replaced.
void simulate(const fs::path& folder, const std::string& seed) {
  const ProgramRun run =
      run_relief({"simulate", "-q", "--views", std::to_string(kViews), "--width", "96", "--height",
                  "96", "--mesh-divisions", "0", "--poses", "exact", "--seed", seed, "-o", folder});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
}

std::vector<std::string> command(const fs::path& scans, const fs::path& out,
                                 const std::vector<std::string>& further = {}) {
  std::vector<std::string> arguments{"run", scans / "scan.json", "-o", out, "--no-html-report"};
  arguments.insert(arguments.end(), further.begin(), further.end());
  return arguments;
}

json counts_of(const fs::path& out) {
  return json::parse(read_text(out / "report.json"))["run"]["cache"];
}

std::size_t sum_of(const json& counts, const std::string& which) {
  std::size_t sum = 0;
  for (const json& kind : counts) sum += kind[which].get<std::size_t>();
  return sum;
}

std::vector<fs::path> kept_files(const fs::path& out) {
  std::vector<fs::path> files;
  for (const std::string& file : files_below(out / ".relief/cache"))
    if (file.find("partial") == std::string::npos) files.push_back(out / ".relief/cache" / file);
  return files;
}

// All results, but for reports, which contain times.
std::vector<std::string> results_in(const fs::path& out) {
  std::vector<std::string> names;
  for (const std::string& file : files_below(out))
    if (file.rfind(".relief", 0) != 0 && file != "report.json") names.push_back(file);
  return names;
}

void expect_same_results(const fs::path& a, const fs::path& b) {
  ASSERT_EQ(results_in(a), results_in(b));
  for (const std::string& file : results_in(a))
    EXPECT_EQ(read_text(a / file), read_text(b / file)) << file;
}

class KeptResults : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    simulate(scans(), "3");
    const ProgramRun run = run_relief(command(scans(), plain(), {"--cache-limit", "0"}));
    ASSERT_EQ(run.exit_status, 0) << run.standard_error;
    const ProgramRun kept = run_relief(command(scans(), full()));
    ASSERT_EQ(kept.exit_status, 0) << kept.standard_error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static fs::path scans() { return *folder_ / "scans"; }
  static fs::path plain() { return *folder_ / "plain"; }  // Without a cache.
  static fs::path full() { return *folder_ / "full"; }    // With all units.

  static inline TemporaryFolder* folder_ = nullptr;
};

void copy_folder(const fs::path& from, const fs::path& to) {
  fs::copy(from, to, fs::copy_options::recursive);
}

TEST_F(KeptResults, ChangeNoByteOfTheResult) {
  EXPECT_FALSE(fs::exists(plain() / ".relief/cache"));
  EXPECT_EQ(kept_files(full()).size(), kUnits);
  expect_same_results(plain(), full());
  const json counts = counts_of(full());
  EXPECT_EQ(counts["refine"]["computed"], kViews);
  EXPECT_EQ(sum_of(counts, "found"), 0u);
  EXPECT_EQ(sum_of(counts, "computed"), kUnits);
  EXPECT_TRUE(counts_of(plain()).empty());
}

TEST_F(KeptResults, AreTakenByTheNextRunOnAnyNumberOfThreads) {
  const TemporaryFolder out;
  copy_folder(full(), out / "again");
  const ProgramRun run = run_relief(command(scans(), out / "again", {"--threads", "1"}));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(run.standard_error, HasSubstr("6 of 6 refined views from an earlier run"));
  EXPECT_EQ(sum_of(counts_of(out / "again"), "found"), kStages);
  EXPECT_EQ(sum_of(counts_of(out / "again"), "computed"), 0u);
  expect_same_results(plain(), out / "again");
}

TEST_F(KeptResults, AreNotTakenByAFreshRun) {
  const TemporaryFolder out;
  copy_folder(full(), out / "again");
  const ProgramRun run = run_relief(command(scans(), out / "again", {"--fresh"}));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_EQ(sum_of(counts_of(out / "again"), "found"), 0u);
  expect_same_results(plain(), out / "again");
}

// Killed over and over, after one more unit or two: every unit that was finished is used.
TEST_F(KeptResults, OutliveKilledRuns) {
  const TemporaryFolder out;
  std::mt19937 random(1);
  std::size_t kept = 0;
  int kills = 0;
  for (;;) {
    const std::size_t enough = kept + random() % 3;
    const ProgramRun run = run_relief_until(
        [&] {
          return kept_files(out / "run").size() >= enough &&
                 kept_files(out / "run").size() < kUnits;
        },
        command(scans(), out / "run"));
    EXPECT_GE(kept_files(out / "run").size(), kept);
    if (run.exit_status == 0) break;
    ASSERT_EQ(run.exit_status, 128 + SIGKILL) << run.standard_error;
    kept = kept_files(out / "run").size();
    ++kills;
    ASSERT_LT(kills, 100);
  }
  EXPECT_GT(kills, 2);
  const json counts = counts_of(out / "run");
  EXPECT_EQ(sum_of(counts, "computed"), kUnits - kept);
  EXPECT_GT(sum_of(counts, "found"), 0u);
  expect_same_results(plain(), out / "run");
}

TEST_F(KeptResults, OfAKilledRunAreNotComputedAgain) {
  const TemporaryFolder out;
  const ProgramRun killed = run_relief_until([&] { return kept_files(out / "run").size() >= 4; },
                                             command(scans(), out / "run", {"--threads", "2"}));
  ASSERT_EQ(killed.exit_status, 128 + SIGKILL);
  const std::size_t kept = kept_files(out / "run").size();
  const ProgramRun run = run_relief(command(scans(), out / "run"));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_GT(sum_of(counts_of(out / "run"), "found"), 0u);
  EXPECT_EQ(sum_of(counts_of(out / "run"), "computed"), kUnits - kept);
  expect_same_results(plain(), out / "run");
}

TEST_F(KeptResults, AreNamedWhenARunIsInterrupted) {
  const TemporaryFolder out;
  const ProgramRun interrupted =
      run_relief_until([&] { return kept_files(out / "run").size() >= 2; },
                       command(scans(), out / "run", {"--threads", "1"}), SIGINT);
  EXPECT_EQ(interrupted.exit_status, 130);
  EXPECT_THAT(interrupted.standard_error, HasSubstr("finished results"));
  EXPECT_THAT(interrupted.standard_error, HasSubstr("the same command goes on from there"));
  const std::size_t kept = kept_files(out / "run").size();
  ASSERT_EQ(run_relief(command(scans(), out / "run")).exit_status, 0);
  EXPECT_EQ(sum_of(counts_of(out / "run"), "computed"), kUnits - kept);
  expect_same_results(plain(), out / "run");
}

TEST_F(KeptResults, AreComputedAgainWhereTheyAreDamaged) {
  const TemporaryFolder out;
  copy_folder(full(), out / "again");
  const std::vector<fs::path> files = kept_files(out / "again");
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::string bytes = read_text(files[i]);
    if (i % 2 == 0)
      bytes.resize(bytes.size() / 2);
    else
      bytes[bytes.size() / 2] ^= 4;
    std::ofstream(files[i], std::ios::binary) << bytes;
  }
  const ProgramRun run = run_relief(command(scans(), out / "again"));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(run.standard_error, HasSubstr("damaged"));
  EXPECT_EQ(sum_of(counts_of(out / "again"), "found"), 0u);
  EXPECT_EQ(sum_of(counts_of(out / "again"), "computed"), kUnits);
  expect_same_results(plain(), out / "again");
}

// Another scan of the view, from the same place.
TEST_F(KeptResults, OfAllOtherViewsStayWhenOneIsReplaced) {
  const TemporaryFolder folder;
  copy_folder(scans(), folder / "scans");
  copy_folder(full(), folder / "out");
  const ProgramRun simulated = run_relief(
      {"simulate", "-q", "--width", "96", "--height", "96", "--mesh-divisions", "0", "--poses",
       "exact", "--seed", "4", "--poses-from", scans() / "truth.json", "-o", folder / "other"});
  ASSERT_EQ(simulated.exit_status, 0) << simulated.standard_error;
  const std::vector<std::string> further{"--contradicted", "keep"};
  ASSERT_EQ(run_relief(command(folder / "scans", folder / "out", further)).exit_status, 0);
  for (const std::string& file : files_below(folder / "scans"))
    if (file.rfind("v002", 0) == 0)
      fs::copy_file(folder / "other" / file, folder / "scans" / file,
                    fs::copy_options::overwrite_existing);
  const ProgramRun run = run_relief(command(folder / "scans", folder / "out", further));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(run.standard_error, HasSubstr("5 of 6 refined views from an earlier run"));
  const json counts = counts_of(folder / "out");
  EXPECT_EQ(counts["refine"]["found"], kViews - 1);
  EXPECT_EQ(counts["refine"]["computed"], 1);
  EXPECT_EQ(counts["merge"]["computed"], 1);
  ASSERT_EQ(run_relief(command(folder / "scans", folder / "plain",
                               {"--contradicted", "keep", "--cache-limit", "0"}))
                .exit_status,
            0);
  expect_same_results(folder / "plain", folder / "out");
}

TEST_F(KeptResults, BelongToOneRunAtATime) {
  const TemporaryFolder out;
  ProgramRun second;
  const ProgramRun first = run_relief_until(
      [&] {
        if (kept_files(out / "run").empty()) return false;
        second = run_relief(command(scans(), out / "run"));
        return true;
      },
      command(scans(), out / "run"));
  EXPECT_EQ(first.exit_status, 128 + SIGKILL);
  EXPECT_EQ(second.exit_status, 2);
  EXPECT_THAT(second.standard_error, HasSubstr("a run works in this folder already (process "));
  EXPECT_EQ(run_relief(command(scans(), out / "run")).exit_status, 0);
}

TEST_F(KeptResults, OutliveADiskWithoutRoom) {
  const TemporaryFolder out;
  const ProgramRun full_disk =
      run_relief(command(scans(), out / "run"), {.file_size_bytes = 100'000});
  EXPECT_EQ(full_disk.exit_status, 2);
  EXPECT_THAT(full_disk.standard_error, HasSubstr("error: "));
  EXPECT_THAT(full_disk.standard_error, HasSubstr("the same command goes on from there"));
  EXPECT_FALSE(kept_files(out / "run").empty());
  const ProgramRun run = run_relief(command(scans(), out / "run"));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_GT(sum_of(counts_of(out / "run"), "found"), 0u);
  expect_same_results(plain(), out / "run");
}

TEST_F(KeptResults, StayWithinTheirLimit) {
  const TemporaryFolder out;
  const ProgramRun run = run_relief(command(scans(), out / "run", {"--cache-limit", "300K"}));
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  std::uintmax_t bytes = 0;
  for (const fs::path& file : kept_files(out / "run")) bytes += fs::file_size(file);
  EXPECT_GT(bytes, 0u);
  EXPECT_LE(bytes, 300u * 1024);
  expect_same_results(plain(), out / "run");
}

TEST_F(KeptResults, AreRemovedOnRequest) {
  const TemporaryFolder out;
  copy_folder(full(), out / "run");
  const ProgramRun run = run_relief({"clean", out / "run"});
  EXPECT_EQ(run.exit_status, 0);
  EXPECT_THAT(run.standard_error,
              HasSubstr("removed " + std::to_string(kUnits) + " results of earlier runs"));
  EXPECT_FALSE(fs::exists(out / "run/.relief"));
  expect_same_results(full(), out / "run");
  EXPECT_THAT(run_relief({"clean", out / "run"}).standard_error, HasSubstr("anything to remove"));
  EXPECT_EQ(run_relief({"clean", out / "nowhere"}).exit_status, 2);
}

TEST_F(KeptResults, AreCountedInTheReportOfCleaning) {
  const TemporaryFolder out;
  copy_folder(full(), out / "run");
  const ProgramRun run =
      run_relief({"clean", out / "run", "--json", "-q", "--report", out / "clean.json"});
  ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  EXPECT_THAT(run.standard_error, IsEmpty());
  for (const std::string& text : {run.standard_output, read_text(out / "clean.json")}) {
    const json report = json::parse(text);
    EXPECT_EQ(report["clean"]["files"], kUnits);
    EXPECT_GT(report["clean"]["bytes"].get<int>(), 0);
  }
}

}  // namespace
}  // namespace relief
