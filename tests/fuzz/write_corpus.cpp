// Writes small valid files to begin fuzzing with: write_corpus FOLDER makes FOLDER/TARGET/FILE.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "scan/io/files/atomic_file.h"
#include "tests/fuzz/corpus_folder.h"

namespace relief::testing {

std::filesystem::path CorpusFolder::path_of(const std::string& target,
                                            const std::string& name) const {
  std::filesystem::create_directories(folder_ / target);
  return folder_ / target / name;
}

void CorpusFolder::add(const std::string& target, const std::string& name,
                       std::string_view content) const {
  const auto written = write_file(path_of(target, name), content);
  if (written) return;
  std::fprintf(stderr, "%s\n", written.error().message.c_str());
  std::exit(1);
}

}  // namespace relief::testing

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_corpus FOLDER\n", stderr);
    return 2;
  }
  const relief::testing::CorpusFolder corpus(argv[1]);
  add_scans(corpus);
  add_meshes(corpus);
  add_images(corpus);
  add_projects(corpus);
  add_workspaces(corpus);
}
