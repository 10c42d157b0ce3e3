#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace relief::testing {

/// Small valid files to begin fuzzing with, in FOLDER/TARGET/NAME. Ends the program with a message
/// when a file cannot be written.
class CorpusFolder {
 public:
  explicit CorpusFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(const std::string& target, const std::string& name, std::string_view content) const;
  /// Where a writer of relief can put the file itself; the folder exists.
  std::filesystem::path path_of(const std::string& target, const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

void add_scans(const CorpusFolder& corpus);
void add_meshes(const CorpusFolder& corpus);
void add_images(const CorpusFolder& corpus);
void add_projects(const CorpusFolder& corpus);
void add_workspaces(const CorpusFolder& corpus);

}  // namespace relief::testing
