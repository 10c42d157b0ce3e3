#include "scan/base/name_list.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

TEST(NameList, CountsWhatItDoesNotName) {
  EXPECT_EQ(name_list({}), "");
  EXPECT_EQ(name_list({"a"}), "a");
  EXPECT_EQ(name_list({"a", "b", "c"}, 3), "a, b, c");
  EXPECT_EQ(name_list({"a", "b", "c", "d"}, 2), "a, b and 2 more");
}

}  // namespace
}  // namespace relief
