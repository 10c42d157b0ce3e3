#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace relief {

/// Names for a line of text, `a, b, c`: the first `limit`, and how many more there are.
std::string name_list(const std::vector<std::string>& names, std::size_t limit = 8);

}  // namespace relief
