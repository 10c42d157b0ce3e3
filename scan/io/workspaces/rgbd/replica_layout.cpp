#include "scan/io/workspaces/rgbd/replica_layout.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/project/json/json_object_private.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Replica's sequences: `depth000000.png` in a folder `results`.
std::vector<fs::path> replica_depths(const fs::path& folder) {
  auto files = files_in(folder / "results");
  std::erase_if(files, [](const fs::path& file) {
    return !has_depth_image_ending(file) || !file.filename().native().starts_with("depth") ||
           !frame_number(file.stem().string());
  });
  return files;
}

}  // namespace

bool has_replica_depths(const fs::path& folder) { return !replica_depths(folder).empty(); }

RgbdFrames replica_frames(const fs::path& folder) {
  constexpr std::string_view kDepth = "depth";
  RgbdFrames found;
  for (const fs::path& file : replica_depths(folder)) {
    RgbdFrame frame;
    frame.depth = file;
    frame.name = file.stem().string().substr(kDepth.size());
    for (const char* ending : {".jpg", ".png"})
      if (const fs::path colour = file.parent_path() / ("frame" + frame.name + ending);
          is_file(colour))
        frame.colour = colour;
    found.frames.push_back(std::move(frame));
  }
  return found;
}

Result<Calibration> parse_replica_camera(std::string_view text, const fs::path& path) {
  return read_json<Calibration>(text, path, [](const json& document) {
    JsonObject camera = JsonObject(document, "").object("camera");
    Calibration calibration;
    calibration.intrinsics = PinholeIntrinsics{camera.positive("fx"), camera.positive("fy"),
                                               camera.number("cx"), camera.number("cy")};
    calibration.size = ImageSize{camera.positive_integer("w"), camera.positive_integer("h")};
    calibration.depth_scale = camera.positive("scale");
    return calibration;
  });
}

}  // namespace relief
