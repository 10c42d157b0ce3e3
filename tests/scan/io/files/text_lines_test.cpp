#include "scan/io/files/text_lines.h"

#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) lines.emplace_back(next_line(text));
  return lines;
}

std::vector<std::string> lines_of_file(const std::string& text) {
  std::istringstream file(text);
  std::vector<std::string> lines;
  for (std::string line; read_line(file, line);) lines.push_back(line);
  return lines;
}

TEST(TextLines, EndInLineFeedsReturnsOrBoth) {
  for (const char* text : {"a b\n\nc\n", "a b\r\n\r\nc\r\n", "a b\r\rc\r", "a b\n\nc"}) {
    EXPECT_THAT(lines_of(text), ElementsAre("a b", "", "c")) << text;
    EXPECT_THAT(lines_of_file(text), ElementsAre("a b", "", "c")) << text;
  }
}

TEST(TextLines, ReturnsBeforeALineFeedAreNoLines) {
  EXPECT_THAT(lines_of("a\r\r\nb\r\r\n"), ElementsAre("a", "b"));
}

}  // namespace
}  // namespace relief
