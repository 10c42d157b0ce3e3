#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace relief::testing {

/// The base of a suite whose tests share scans. `relief simulate` makes them once, with the
/// arguments that `Suite::simulation()` gives.
template <typename Suite>
class SimulatedScans : public ::testing::Test {
 public:
  static void SetUpTestSuite() {
    scans_ = std::make_unique<TemporaryFolder>();
    std::vector<std::string> arguments{"simulate", "-q", "-o", scans_->path().string()};
    const std::vector<std::string> more = Suite::simulation();
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_relief(arguments);
    ASSERT_EQ(run.exit_status, 0) << run.standard_error;
  }
  static void TearDownTestSuite() { scans_.reset(); }

 protected:
  static const TemporaryFolder& scans() { return *scans_; }
  static std::string scan() { return *scans_ / "scan.json"; }
  static std::string truth() { return *scans_ / "truth/scan.json"; }
  static std::string model() { return *scans_ / "truth/model.ply"; }

 private:
  inline static std::unique_ptr<TemporaryFolder> scans_;
};

}  // namespace relief::testing
