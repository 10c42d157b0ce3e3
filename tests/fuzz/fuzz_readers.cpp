// Readers of files under libFuzzer: scripts/fuzz TARGET SECONDS. The input is the content of one
// file, whose name gives the reader; RELIEF_FUZZ_READER tells which one of the list below.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>

#include <unistd.h>

#include "relief/io/mesh_io.h"
#include "relief/io/project_io.h"
#include "scan/io/images/image_io.h"
#include "scan/io/project/scan_file.h"
#include "scan/io/project/view_spec.h"

namespace {

namespace fs = std::filesystem;

struct FuzzedReader {
  std::string file_name;
  std::function<void(const fs::path&)> read;
};

void read_scans(const fs::path& path) {
  const auto scans = relief::list_scans(path);
  for (std::size_t i = 0; scans && i < std::min<std::size_t>(scans->size(), 3); ++i)
    (void)relief::read_scan_file(path, (*scans)[i]);
}

const std::map<std::string, FuzzedReader>& fuzzed_readers() {
  const auto image = [](const fs::path& path) { (void)relief::read_image(path); };
  const auto mesh = [](const fs::path& path) { (void)relief::read_mesh(path); };
  const auto project = [](const fs::path& path) { (void)relief::read_project_spec(path); };
  static const std::map<std::string, FuzzedReader> kReaders = {
      {"ply_grid", {"scan.ply", read_scans}},
      {"grid_view", {"scan.ply", [](const fs::path& path) { (void)relief::read_project(path); }}},
      {"pcd", {"scan.pcd", read_scans}},
      {"pts", {"scan.pts", read_scans}},
      {"png", {"image.png", image}},
      {"tiff", {"image.tiff", image}},
      {"exr", {"image.exr", image}},
      {"pfm", {"image.pfm", image}},
      {"jpeg", {"image.jpg", image}},
      {"pnm", {"image.pgm", image}},
      {"bmp", {"image.bmp", image}},
      {"tga", {"image.tga", image}},
      {"hdr", {"image.hdr", image}},
      {"webp", {"image.webp", image}},
      {"npy", {"image.npy", image}},
      {"raw",
       {"image.raw",
        [](const fs::path& path) {
          (void)relief::read_image(path, {{5, 4}});
        }}},
      {"ply_mesh", {"mesh.ply", mesh}},
      {"obj", {"mesh.obj", mesh}},
      {"stl", {"mesh.stl", mesh}},
      {"vtp", {"mesh.vtp", mesh}},
      {"scan_json", {"scan.json", project}},
      {"conf", {"scan.conf", project}},
      {"aln", {"scan.aln", project}},
      {"poses", {"poses.json", [](const fs::path& path) { (void)relief::read_poses(path); }}},
  };
  return kReaders;
}

const FuzzedReader& chosen_reader() {
  const char* name = std::getenv("RELIEF_FUZZ_READER");
  const auto found = fuzzed_readers().find(name ? name : "");
  if (found != fuzzed_readers().end()) return found->second;
  std::fputs("set RELIEF_FUZZ_READER to one of:", stderr);
  for (const auto& [known, reader] : fuzzed_readers()) std::fprintf(stderr, " %s", known.c_str());
  std::fputs("\n", stderr);
  std::exit(2);
}

// A folder of this process, in memory where there is such a file system.
fs::path fuzz_folder() {
  const fs::path base = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  const fs::path folder = base / ("relief-fuzz-" + std::to_string(getpid()));
  fs::create_directories(folder);
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzedReader& reader = chosen_reader();
  static const fs::path path = fuzz_folder() / reader.file_name;
  {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  }
  reader.read(path);
  return 0;
}
