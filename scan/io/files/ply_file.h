#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/page_allocator.h"
#include "relief/scan/result.h"

namespace relief {

/// One column of a PLY element. Every scalar type of the format fits a double exactly. Under a
/// memory limit large columns lie in files.
struct PlyProperty {
  std::string name;
  bool is_list = false;
  /// Scalar: one value per instance. List: the values of all instances one after the other.
  PagedVector<double> values;
  /// List: values of instance i are [starts[i], starts[i+1]). Empty for scalars.
  PagedVector<std::size_t> starts;
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  const PlyProperty* find(std::string_view property) const;
};

/// The content of a Stanford PLY file.
struct PlyFile {
  std::map<std::string, std::string> object_info;  ///< `obj_info KEY VALUE` lines of the header.
  std::vector<PlyElement> elements;

  const PlyElement* find(std::string_view element) const;
};

/// Parses ASCII and binary PLY of either byte order. Errors (kBadInput) name `path` and the line
/// (ASCII) or the element and the byte (binary). Nothing is allocated that the content could not
/// fill, whatever its header says. `parsed` (may be empty) is told now and then how many bytes from
/// the first on are not needed any more.
Result<PlyFile> parse_ply(std::string_view content, const std::filesystem::path& path,
                          const std::function<void(std::size_t)>& parsed = {});

Result<PlyFile> read_ply(const std::filesystem::path& path);

}  // namespace relief
