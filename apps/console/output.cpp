#include "apps/console/output.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <unistd.h>

#include "relief/io/mesh_io.h"

namespace relief {

Result<void> prepare_folder(const std::filesystem::path& folder) {
  const std::filesystem::path here = folder.empty() ? "." : folder;
  std::error_code failure;
  std::filesystem::create_directories(here, failure);
  if (failure)
    return Error{ErrorKind::kCannotWrite,
                 here.string() + ": cannot create this folder: " + failure.message()};
  if (access(here.c_str(), W_OK) != 0)
    return Error{ErrorKind::kCannotWrite,
                 here.string() + ": cannot write into this folder: " + std::strerror(errno)};
  return {};
}

Result<void> prepare_folder_of(const std::filesystem::path& file) {
  return prepare_folder(file.parent_path());
}

CLI::Validator known_mesh_ending() {
  return CLI::Validator(
      [](const std::string& name) {
        if (is_mesh_path(name)) return std::string();
        return "no mesh format has the ending of " + name +
               ": use .ply .obj .stl .vtp .glb or .3mf";
      },
      "MESH");
}

}  // namespace relief
