#include "apps/reports/run_record.h"

#include <map>
#include <string>

#include <gtest/gtest.h>

namespace relief {
namespace {

enum class Scope { kOff, kAuto, kShared };

// A command with an option of each kind, in a group as in the program.
class RunRecord : public ::testing::Test {
 protected:
  RunRecord() {
    const std::map<std::string, Scope> scopes = {
        {"auto", Scope::kAuto}, {"off", Scope::kOff}, {"shared", Scope::kShared}};
    CLI::Option* option = group_->add_option("--scope", scope_)
                              ->transform(CLI::CheckedTransformer(scopes))
                              ->default_str("auto");
    group_->add_option("--former-scope", scope_)
        ->transform(CLI::CheckedTransformer(scopes))
        ->excludes(option);
    group_->add_option("--ranges", ranges_)
        ->check(CLI::IsMember({"keep", "weigh"}))
        ->default_str("keep");
    group_->add_option("--rounds", rounds_)->check(CLI::Range(0, 100))->capture_default_str();
    group_->add_flag("--no-polish", no_polish_);
  }

  Json options_of(const std::string& arguments) {
    command_.parse(arguments);
    return run_record("scan.json", command_)["options"];
  }

  CLI::App command_;
  CLI::Option_group* group_ = command_.add_option_group("Group");
  Scope scope_ = Scope::kAuto;
  std::string ranges_ = "keep";
  int rounds_ = 3;
  bool no_polish_ = false;
};

TEST_F(RunRecord, HasTheWordsThatWereGiven) {
  EXPECT_EQ(
      options_of("--scope off --ranges weigh --rounds 5 --no-polish"),
      (Json{
          {"--scope", "off"}, {"--ranges", "weigh"}, {"--rounds", "5"}, {"--no-polish", "true"}}));
  EXPECT_EQ(scope_, Scope::kOff);
}

TEST_F(RunRecord, HasTheWordsOfDefaults) {
  EXPECT_EQ(options_of(""), (Json{{"--scope", "auto"}, {"--ranges", "keep"}}));
}

TEST_F(RunRecord, HasTheWordOfAValue) { EXPECT_EQ(options_of("--scope 2")["--scope"], "shared"); }

TEST_F(RunRecord, HasNoDefaultWhereTheFormerNameWasGiven) {
  const Json options = options_of("--former-scope shared");
  EXPECT_EQ(options["--former-scope"], "shared");
  EXPECT_FALSE(options.contains("--scope"));
}

}  // namespace
}  // namespace relief
