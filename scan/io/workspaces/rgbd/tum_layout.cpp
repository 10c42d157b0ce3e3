#include "scan/io/workspaces/rgbd/tum_layout.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Depth values per metre that define the format of TUM's sequences.
constexpr double kTumDepthScale = 5000.0;

template <typename Parsed>
Result<Parsed> parse_file(const fs::path& path,
                          Result<Parsed> (*parse)(std::string_view, const fs::path&)) {
  const auto text = read_file(path);
  if (!text) return text.error();
  return parse(*text, path);
}

// A file of a list, which may be from another machine: the longest end of its path that is there.
fs::path listed_file(const fs::path& folder, std::string name) {
  std::ranges::replace(name, '\\', '/');
  const fs::path listed(name);
  for (auto part = listed.begin(); part != listed.end(); ++part) {
    fs::path end;
    for (auto next = part; next != listed.end(); ++next) end /= *next;
    if (is_file(folder / end)) return folder / end;
  }
  return folder / listed;
}

// The colour image nearest in time.
std::optional<std::string> colour_at(const std::vector<TimedFile>& colours, double time) {
  const auto after =
      std::lower_bound(colours.begin(), colours.end(), time,
                       [](const TimedFile& colour, double t) { return colour.time < t; });
  const TimedFile* nearest = nullptr;
  for (auto it = after == colours.begin() ? after : std::prev(after);
       it != colours.end() && it <= after; ++it)
    if (!nearest || std::abs(it->time - time) < std::abs(nearest->time - time)) nearest = &*it;
  if (!nearest || std::abs(nearest->time - time) > kSameMoment) return std::nullopt;
  return nearest->file;
}

// The moments of a TUM folder: from its associations, or from its two lists.
Result<std::vector<FilePair>> tum_moments(const fs::path& folder) {
  if (!has_tum_list(folder))
    return parse_file(tum_association_file(folder).value_or(folder), parse_tum_associations);
  auto depths = parse_file(folder / "depth.txt", parse_tum_list);
  if (!depths) return depths.error();
  std::vector<TimedFile> colours;
  if (is_file(folder / "rgb.txt")) {
    auto list = parse_file(folder / "rgb.txt", parse_tum_list);
    if (!list) return list.error();
    colours = std::move(*list);
  }
  const auto earlier = [](const TimedFile& a, const TimedFile& b) { return a.time < b.time; };
  std::stable_sort(colours.begin(), colours.end(), earlier);
  std::stable_sort(depths->begin(), depths->end(), earlier);
  std::vector<FilePair> moments;
  for (TimedFile& depth : *depths) {
    const auto colour = colour_at(colours, depth.time);
    moments.push_back({std::move(depth), {0.0, colour.value_or("")}});
  }
  return moments;
}

}  // namespace

std::optional<fs::path> tum_association_file(const fs::path& folder) {
  for (const fs::path& file : files_in(folder))
    if (lower_ending(file) == ".txt" &&
        kind_of_rgbd_text(first_bytes(file)) == RgbdText::kAssociations)
      return file;
  return std::nullopt;
}

bool has_tum_list(const fs::path& folder) {
  return kind_of_rgbd_text(first_bytes(folder / "depth.txt")) == RgbdText::kList;
}

Result<RgbdFrames> tum_frames(const fs::path& folder) {
  auto moments = tum_moments(folder);
  if (!moments) return moments.error();
  RgbdFrames frames;
  frames.usual_depth_scale = kTumDepthScale;
  std::size_t missing = 0;
  for (const FilePair& moment : *moments) {
    RgbdFrame frame;
    frame.depth = listed_file(folder, moment.depth.file);
    frame.name = frame.depth.stem().string();
    frame.time = moment.depth.time;
    if (const fs::path colour = listed_file(folder, moment.colour.file); is_file(colour))
      frame.colour = colour;
    if (is_file(frame.depth))
      frames.frames.push_back(std::move(frame));
    else
      ++missing;
  }
  if (frames.frames.empty())
    return bad_input(folder, "none of the " + std::to_string(missing) +
                                 " depth maps that its list names is there; unpack the images "
                                 "beside the list");
  if (missing > 0)
    frames.notes.push_back("left out " + std::to_string(missing) +
                           " depth maps that are listed but not there");
  if (has_tum_list(folder) && is_file(folder / "rgb.txt")) frames.depth_scale = kTumDepthScale;
  return frames;
}

}  // namespace relief
