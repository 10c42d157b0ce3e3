// The guarantee of merging over many random small scenes: views dropped, doubled, masked, displaced
// and noisy. Each scene is merged and polished; both surfaces are checked by check_mesh (with
// self-intersections) and, unless told otherwise, by admesh, which shares no code with relief.
//   build/bench/bench/relief_merge_scenes --scenes 500 --seed 0
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "relief/fusion/merge_views.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/io/mesh_io.h"
#include "relief/scan/context.h"
#include "tests/fusion/scenes.h"

namespace relief {
namespace {

struct SceneOptions {
  int scenes = 500;
  std::uint32_t seed = 0;
  bool admesh = true;
  int threads = 0;
};

struct Tally {
  int merged = 0, polished = 0, wrong = 0, confirmed = 0;
  std::size_t faces = 0;
  std::map<std::string, int> errors;  // How often each was reported.
};

// What `command` prints.
std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  std::array<char, 4096> buffer;
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get())) output += buffer.data();
  return output;
}

// The number that admesh prints behind `name`; -1 if it does not.
long counted(const std::string& output, const std::string& name) {
  const auto place = output.find(name);
  const auto colon = place == std::string::npos ? place : output.find(':', place);
  return colon == std::string::npos ? -1 : std::strtol(output.c_str() + colon + 1, nullptr, 10);
}

bool admesh_agrees(const TriangleMesh& mesh, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "scene.stl";
  if (!write_mesh(mesh, file)) return false;
  const std::string output =
      output_of("admesh --no-check --exact --normal-directions '" + file.string() + "' 2>&1");
  return counted(output, "Total disconnected facets") == 0 &&
         counted(output, "Degenerate facets") == 0 && counted(output, "Facets reversed") == 0;
}

std::string faults_of(const TriangleMesh& mesh, const SceneOptions& options,
                      const std::filesystem::path& folder, Tally& tally) {
  const MeshCheck check = check_mesh(mesh, {.self_intersections = true});
  std::string faults;
  if (!check.watertight()) faults += " not watertight;";
  if (!check.self_intersections->pairs.empty())
    faults += " " + std::to_string(check.self_intersections->pairs.size()) + " self-intersections;";
  if (options.admesh) {
    if (admesh_agrees(mesh, folder))
      ++tally.confirmed;
    else
      faults += " admesh disagrees;";
  }
  return faults;
}

void run_scene(const std::vector<RangeView>& views, std::uint32_t seed, const SceneOptions& options,
               const std::filesystem::path& folder, Tally& tally) {
  const auto merged = fusion::merge_views(views);
  if (!merged) {
    ++tally.errors[merged.error().message];
    return;
  }
  ++tally.merged;
  tally.faces += merged->mesh.faces.size();
  std::string faults = faults_of(merged->mesh, options, folder, tally);
  hybrid::PolishOptions polish;
  polish.normals.max_distance = merged->truncation;
  const auto polished = hybrid::polish_mesh(merged->mesh, views, polish);
  if (polished && polished->rounds > 0) {
    ++tally.polished;
    const std::string after = faults_of(polished->mesh, options, folder, tally);
    if (!after.empty()) faults += " polished:" + after;
  }
  if (faults.empty()) return;
  ++tally.wrong;
  std::printf("scene %u:%s\n", seed, faults.c_str());
}

int run(const SceneOptions& options) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("relief-scenes-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const testing::RandomScenes scenes;
  Tally tally;
  for (int i = 0; i < options.scenes; ++i) {
    const std::uint32_t seed = options.seed + static_cast<std::uint32_t>(i);
    run_scene(scenes.scene(seed), seed, options, folder, tally);
  }
  std::filesystem::remove_all(folder);
  std::printf("%d scenes: %d merged (%zu faces), %d of these polished, %d with a fault\n",
              options.scenes, tally.merged, tally.faces, tally.polished, tally.wrong);
  if (options.admesh)
    std::printf("admesh finds %d of %d surfaces closed\n", tally.confirmed,
                tally.merged + tally.polished);
  for (const auto& [message, count] : tally.errors)
    std::printf("%d x %s\n", count, message.c_str());
  return tally.wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace relief

int main(int argc, char** argv) {
  relief::SceneOptions options;
  CLI::App app("Merges random small scenes and checks that every surface is a closed manifold");
  app.add_option("--scenes", options.scenes, "Number of scenes")->capture_default_str();
  app.add_option("--seed", options.seed, "The first scene")->capture_default_str();
  app.add_flag("!--no-admesh", options.admesh, "Do not ask admesh");
  app.add_option("--threads", options.threads, "0: one per core")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return relief::on_threads(options.threads, [&] { return relief::run(options); });
}
