#include "relief/reconstruction/unit_folder.h"

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "relief/scan/context.h"
#include "scan/units/content_hash.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief::reconstruction {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

const UnitKey& key() {
  static const UnitKey key = unit_key("refine", 1);
  return key;
}

fs::path file_of(const TemporaryFolder& folder, const UnitKey& key) {
  return folder.path() / key.hash.substr(0, 2) / key.hash;
}

std::unique_ptr<UnitFolder> opened(const TemporaryFolder& folder,
                                   const UnitFolderOptions& options = {}) {
  return std::move(*UnitFolder::open(folder.path(), options));
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(UnitFolder, FindsWhatAnotherOneKept) {
  const TemporaryFolder folder;
  const std::string content("with\0zero\n", 10);
  opened(folder)->keep(key(), content);
  const auto units = opened(folder);
  EXPECT_EQ(units->find(key()), content);
  EXPECT_EQ(units->find(unit_key("refine", 2)), std::nullopt);
  EXPECT_EQ(units->find(unit_key("merge", 1)), std::nullopt);
  EXPECT_EQ(units->counts()["refine"].found, 1u);
  EXPECT_EQ(units->counts()["refine"].computed, 0u);
  EXPECT_EQ(units->files(), 1u);
  EXPECT_EQ(units->bytes(), fs::file_size(file_of(folder, key())));
  EXPECT_THAT(units->take_warnings(), IsEmpty());
}

TEST(UnitFolder, FindsAnEmptyResult) {
  const TemporaryFolder folder;
  opened(folder)->keep(key(), "");
  EXPECT_EQ(opened(folder)->find(key()), "");
}

TEST(UnitFolder, GivesUpALargeResultWhenTheWorkIsStoppedAndKeepsASmallOne) {
  const TemporaryFolder folder;
  const auto units = opened(folder);
  const std::string large(std::size_t{70} << 20, 'x');
  for (const std::string& content : {large, std::string("small")}) {
    std::stop_source source;
    Context context;
    context.stop = source.get_token();
    (void)run_in(context, [&]() -> Result<void> {
      source.request_stop();
      units->keep(unit_key("merge", content.size()), content);
      return {};
    });
  }
  EXPECT_EQ(units->find(unit_key("merge", large.size())), std::nullopt);
  EXPECT_EQ(units->find(unit_key("merge", std::size_t{5})), "small");
  EXPECT_EQ(units->files(), 1u);
  EXPECT_LT(units->bytes(), 1000u);  // The room of the large one was given back.
  for (const auto& entry : fs::directory_iterator(folder.path()))
    EXPECT_TRUE(entry.is_directory()) << entry.path() << " is left over";
}

TEST(UnitFolder, NoticesEveryFlippedBitAndEveryCut) {
  const TemporaryFolder folder;
  opened(folder)->keep(key(), "content");
  const std::string good = read(file_of(folder, key()));
  std::vector<std::string> damaged{good + "x", ""};
  for (std::size_t i = 0; i < good.size(); ++i) {
    damaged.push_back(good.substr(0, i));
    for (int bit = 0; bit < 8; ++bit) {
      damaged.push_back(good);
      damaged.back()[i] = static_cast<char>(damaged.back()[i] ^ (1 << bit));
    }
  }
  for (const std::string& bytes : damaged) {
    const auto units = opened(folder);
    std::ofstream(file_of(folder, key()), std::ios::binary) << bytes;
    ASSERT_EQ(units->find(key()), std::nullopt) << bytes;
    EXPECT_THAT(units->take_warnings(), ::testing::ElementsAre(HasSubstr(key().hash)));
    EXPECT_FALSE(fs::exists(file_of(folder, key())));
  }
}

TEST(UnitFolder, DoesNotBelieveAFileUnderAnotherKey) {
  const TemporaryFolder folder;
  const UnitKey other = unit_key("refine", 2);
  opened(folder)->keep(key(), "content");
  fs::create_directories(file_of(folder, other).parent_path());
  fs::rename(file_of(folder, key()), file_of(folder, other));
  EXPECT_EQ(opened(folder)->find(other), std::nullopt);
}

// Two steps that compute the same unit: a third one finds it at any time.
TEST(UnitFolder, ReplacesAUnitInOneMove) {
  const TemporaryFolder folder;
  const auto first = opened(folder), second = opened(folder);
  first->keep(key(), "content");
  EXPECT_EQ(second->find(key()), "content");
  std::atomic<bool> done = false;
  std::thread writer([&] {
    for (int i = 0; i < 200; ++i) first->keep(key(), "content");
    done = true;
  });
  while (!done) EXPECT_TRUE(second->find(key()));
  writer.join();
  EXPECT_THAT(second->take_warnings(), IsEmpty());
}

TEST(UnitFolder, FindsNothingWhenFreshAndReplacesWhatIsThere) {
  const TemporaryFolder folder;
  opened(folder)->keep(key(), "old");
  const auto units = opened(folder, {.fresh = true});
  EXPECT_EQ(units->find(key()), std::nullopt);
  units->keep(key(), "new");
  EXPECT_EQ(units->files(), 1u);
  EXPECT_EQ(opened(folder)->find(key()), "new");
}

TEST(UnitFolder, RemovesWhatWasUsedLongestAgo) {
  const TemporaryFolder folder;
  const std::string content(1000, 'x');
  for (int i = 0; i < 3; ++i) opened(folder)->keep(unit_key("refine", i), content);
  for (int i = 0; i < 3; ++i)
    fs::last_write_time(file_of(folder, unit_key("refine", i)),
                        fs::file_time_type::clock::now() - std::chrono::hours(i == 1 ? 5 : 1));
  ASSERT_TRUE(opened(folder)->find(unit_key("refine", 0)));  // Its last use is now.
  const auto units = opened(folder, {.limit = 4000});
  units->keep(unit_key("refine", 3), content);
  EXPECT_FALSE(units->find(unit_key("refine", 1)));
  EXPECT_TRUE(units->find(unit_key("refine", 0)));
  EXPECT_TRUE(units->find(unit_key("refine", 2)));
  EXPECT_TRUE(units->find(unit_key("refine", 3)));
  EXPECT_LE(units->bytes(), 4000u);
  EXPECT_THAT(units->take_warnings(), IsEmpty());
}

TEST(UnitFolder, KeepsTheResultsOfThisRunWithinItsLimit) {
  const TemporaryFolder folder;
  const auto units = opened(folder, {.limit = 2500});
  for (int i = 0; i < 4; ++i) units->keep(unit_key("refine", i), std::string(1000, 'x'));
  EXPECT_TRUE(units->find(unit_key("refine", 0)));
  EXPECT_TRUE(units->find(unit_key("refine", 1)));
  EXPECT_FALSE(units->find(unit_key("refine", 2)));
  EXPECT_LE(units->bytes(), 2500u);
  EXPECT_THAT(units->take_warnings(), ::testing::ElementsAre(HasSubstr("limit")));
  EXPECT_EQ(units->counts()["refine"].computed, 4u);
}

// As on a full disk: larger files cannot be written.
class SmallFiles {
 public:
  SmallFiles() : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit small{500, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST(UnitFolder, GoesOnWithoutRoomOnTheDisk) {
  const TemporaryFolder folder;
  const auto units = opened(folder);
  {
    const SmallFiles limited;
    units->keep(unit_key("refine", 0), std::string(1000, 'x'));
    units->keep(unit_key("refine", 1), std::string(1000, 'x'));
  }
  EXPECT_THAT(units->take_warnings(), ::testing::ElementsAre(HasSubstr("cannot be kept")));
  EXPECT_EQ(units->files(), 0u);
  EXPECT_EQ(units->bytes(), 0u);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    EXPECT_TRUE(entry.is_directory()) << entry.path();
  units->keep(unit_key("refine", 0), "small");
  EXPECT_EQ(opened(folder)->find(unit_key("refine", 0)), "small");
}

TEST(UnitFolder, SaysWhenItCannotBeCreated) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "");
  EXPECT_THAT(UnitFolder::open(file / "cache"), HasError(ErrorKind::kCannotWrite, file.string()));
}

}  // namespace
}  // namespace relief::reconstruction
