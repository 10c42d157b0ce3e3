#include "apps/commands/outputs.h"

#include <set>
#include <string>
#include <system_error>

#include "scan/io/files/real_path.h"
#include "scan/io/project/project_files.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

Error overwritten(const fs::path& file) {
  return {ErrorKind::kBadInput,
          file.string() +
              ": is one of the input files and would be overwritten; give another output with -o"};
}

}  // namespace

Result<void> check_outputs(const ProjectInput& input, const Outputs& outputs) {
  const auto project = read_project_spec(input.path, input.options);
  if (!project) return project.error();
  std::set<fs::path> read;
  for (const fs::path& file : files_read_for(*project)) read.insert(real_path(file));
  std::vector<fs::path> written = outputs.files;
  if (!outputs.folder.empty())
    for (fs::path& file : files_written_for(*project, outputs.folder))
      written.push_back(std::move(file));
  std::error_code code;
  for (const fs::path& file : written)
    if (fs::exists(file, code) && read.contains(real_path(file))) return overwritten(file);
  if (outputs.folder.empty() || real_path(outputs.folder) != real_path(input.path)) return {};
  return Error{ErrorKind::kBadInput,
               outputs.folder.string() +
                   ": is the folder of the scans, and its results would be read in place of them "
                   "from then on; give another folder with -o"};
}

Result<void> check_output(const fs::path& input, const fs::path& output) {
  std::error_code code;
  if (fs::exists(output, code) && real_path(input) == real_path(output)) return overwritten(output);
  return {};
}

}  // namespace relief
