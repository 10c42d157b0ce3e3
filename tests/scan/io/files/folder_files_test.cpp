#include "scan/io/files/folder_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::ElementsAre;
using testing::TemporaryFolder;

TEST(NaturalOrder, RunsOfDigitsGoByTheirValue) {
  EXPECT_TRUE(natural_less("2.png", "10.png"));
  EXPECT_TRUE(natural_less("view9_b", "view10_a"));
  EXPECT_TRUE(natural_less("a", "a1"));
  EXPECT_TRUE(natural_less("99999999999999999999", "100000000000000000000"));
  EXPECT_FALSE(natural_less("10.png", "2.png"));
}

TEST(NaturalOrder, TellsAllNamesApart) {
  const std::vector<std::string_view> names = {"", "0", "00", "a1", "a01", "a1b", "a01b", "b"};
  for (const auto a : names)
    for (const auto b : names)
      EXPECT_EQ(natural_less(a, b) + natural_less(b, a), a == b ? 0 : 1) << a << " " << b;
}

TEST(FilesIn, ListsFilesNotFoldersByTheirNumbers) {
  const TemporaryFolder folder;
  for (const char* name : {"10.png", "9.png", "1.png"}) folder.write(name, "");
  std::filesystem::create_directories(folder / "2.png");
  std::vector<std::string> names;
  for (const auto& file : files_in(folder / ".")) names.push_back(file.filename().string());
  EXPECT_THAT(names, ElementsAre("1.png", "9.png", "10.png"));
  EXPECT_TRUE(files_in(folder / "absent").empty());
}

}  // namespace
}  // namespace relief
