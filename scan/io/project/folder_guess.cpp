#include "scan/io/project/folder_guess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/files/io_error.h"
#include "scan/io/images/image_size.h"
#include "scan/io/project/json/spec_json_private.h"
#include "scan/io/workspaces/middlebury_par.h"
#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"
#include "scan/io/workspaces/rgbd/calibration/calibration.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

enum class ImageRole { kDepth, kNormals, kMask, kConfidence, kColour };

struct RoleWord {
  const char* word;
  ImageRole role;
};

// Words in names of files and folders, as scanners' programs and public data sets write them.
constexpr std::array kRoleWords{
    RoleWord{"depth", ImageRole::kDepth},     RoleWord{"range", ImageRole::kDepth},
    RoleWord{"dist", ImageRole::kDepth},      RoleWord{"distance", ImageRole::kDepth},
    RoleWord{"z", ImageRole::kDepth},         RoleWord{"normal", ImageRole::kNormals},
    RoleWord{"normals", ImageRole::kNormals}, RoleWord{"nrm", ImageRole::kNormals},
    RoleWord{"mask", ImageRole::kMask},       RoleWord{"silhouette", ImageRole::kMask},
    RoleWord{"conf", ImageRole::kConfidence}, RoleWord{"confidence", ImageRole::kConfidence},
    RoleWord{"color", ImageRole::kColour},    RoleWord{"colour", ImageRole::kColour},
    RoleWord{"rgb", ImageRole::kColour},      RoleWord{"albedo", ImageRole::kColour},
    RoleWord{"image", ImageRole::kColour}};

// The letters of a name in groups: `view01_depth` has `view`, `01` and `depth`.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words;
  char before = '\0';
  for (const char c : name) {
    const auto kind = [](char letter) {
      const auto byte = static_cast<unsigned char>(letter);
      return std::isalpha(byte) ? 1 : std::isdigit(byte) ? 2 : 0;
    };
    if (kind(c) == 0) {
      before = '\0';
      continue;
    }
    if (before == '\0' || kind(before) != kind(c)) words.emplace_back();
    words.back() += c;
    before = c;
  }
  return words;
}

std::optional<ImageRole> role_of_word(const std::string& word) {
  for (const RoleWord& known : kRoleWords)
    if (word == known.word) return known.role;
  return std::nullopt;
}

// What the name of a file tells.
struct ImageName {
  std::optional<ImageRole> role;
  std::string view;  // The rest of the name.
};

ImageName name_of_image(const fs::path& file) {
  ImageName name;
  for (const std::string& word : words_of(lower_case(file.stem().string()))) {
    const auto found = role_of_word(word);
    if (found && !name.role) {
      name.role = found;
      continue;
    }
    name.view += (name.view.empty() ? "" : "_") + word;
  }
  if (name.view.empty()) name.view = "view";
  return name;
}

struct NamedImage {
  fs::path file;
  ImageRole role;
  std::string view;
};

// The role is told by the name of the file, else by that of its folder, where single letters say
// nothing.
std::optional<NamedImage> named_image(const fs::path& file, const std::string& folder_name) {
  ImageName name = name_of_image(file);
  if (!name.role)
    for (const std::string& word : words_of(lower_case(folder_name)))
      if (!name.role && word.size() > 1) name.role = role_of_word(word);
  const bool can_be_depth = has_depth_image_ending(file);
  if (!name.role || (name.role == ImageRole::kDepth && !can_be_depth)) return std::nullopt;
  return NamedImage{file, *name.role, name.view};
}

bool is_image(const fs::path& path) {
  return has_depth_image_ending(path) || has_photograph_ending(path);
}

void add_images(const fs::path& folder, const std::string& folder_name,
                std::vector<NamedImage>& images) {
  for (const fs::path& file : files_in(folder))
    if (is_image(file))
      if (auto image = named_image(file, folder_name)) images.push_back(std::move(*image));
}

bool has_depth(const std::vector<NamedImage>& images) {
  return std::ranges::any_of(
      images, [](const NamedImage& image) { return image.role == ImageRole::kDepth; });
}

// Where no name tells depth maps: `7.png` of 16 grey bits is one, and `7.jpg` has its colours.
std::vector<NamedImage> images_by_their_bits(const fs::path& folder) {
  std::vector<NamedImage> images;
  for (const fs::path& file : files_in(folder)) {
    const ImageName name = name_of_image(file);
    if (!is_image(file) || (name.role && name.role != ImageRole::kColour)) continue;
    const bool depth = !name.role && is_grey_16_bit_png(file);
    images.push_back({file, depth ? ImageRole::kDepth : ImageRole::kColour, name.view});
  }
  return has_depth(images) ? images : std::vector<NamedImage>();
}

// Those of the folder itself and of the folders in it, by name.
std::vector<NamedImage> images_in(const fs::path& folder) {
  std::vector<NamedImage> images;
  std::error_code code;
  add_images(folder, fs::weakly_canonical(folder, code).filename().string(), images);
  for (const auto& entry : fs::directory_iterator(folder, code))
    if (entry.is_directory(code) && !is_hidden(entry.path()))
      add_images(entry.path(), entry.path().filename().string(), images);
  if (!has_depth(images))
    if (auto by_bits = images_by_their_bits(folder); !by_bits.empty()) images = std::move(by_bits);
  std::sort(images.begin(), images.end(), [](const auto& a, const auto& b) {
    return natural_less(a.file.native(), b.file.native());
  });
  return images;
}

CameraSpec unknown_camera(const fs::path& depth) {
  CameraSpec camera;
  if (const auto size = image_size(depth)) {
    camera.width = size->width;
    camera.height = size->height;
    camera.intrinsics.cx = 0.5 * (size->width - 1);
    camera.intrinsics.cy = 0.5 * (size->height - 1);
  }
  return camera;
}

using CamerasByView = std::map<std::string, MiddleburyCamera>;

// Those of a Middlebury list (`NAME_par.txt`) in the folder.
CamerasByView listed_cameras(const fs::path& folder, FolderGuess& guess) {
  CamerasByView cameras;
  for (const fs::path& file : files_in(folder)) {
    if (!file.filename().string().ends_with("_par.txt")) continue;
    const auto list = read_middlebury_par(file);
    if (!list) {
      guess.findings.push_back("left out " + list.error().message);
      continue;
    }
    guess.findings.push_back("cameras and poses of " + std::to_string(list->size()) +
                             " images from " + file.string());
    for (const MiddleburyCamera& camera : *list)
      cameras.emplace(name_of_image(camera.file).view, camera);
  }
  return cameras;
}

void take_listed_camera(const CamerasByView& cameras, ViewSpec& view) {
  const auto found = cameras.find(view.name);
  if (found == cameras.end() || !view.camera) return;
  view.camera->intrinsics = found->second.intrinsics;
  view.world_from_view = found->second.world_from_view;
  view.pose = PoseKind::kGuess;
}

// Depth maps of whole numbers hold millimetres far more often than metres.
bool holds_whole_numbers(const fs::path& depth) {
  const std::string ending = lower_ending(depth);
  return ending == ".png" || ending == ".pgm";
}

ViewSpec guessed_view(const std::string& name, const std::vector<NamedImage>& images,
                      const ReadProjectOptions& options) {
  ViewSpec view;
  view.name = name;
  for (const NamedImage& image : images) {
    switch (image.role) {
      case ImageRole::kDepth:
        view.depth = DepthSpec{image.file, 1.0, false};
        if (options.depth_scale) view.depth->scale = metres_per_step(*options.depth_scale);
        break;
      case ImageRole::kNormals:
        view.normals = NormalSpec{image.file, {}, {}, {}};
        break;
      case ImageRole::kMask:
        view.mask = ImageFile{image.file};
        break;
      case ImageRole::kConfidence:
        view.confidence = ImageFile{image.file};
        break;
      case ImageRole::kColour:
        view.colour = ImageFile{image.file};
        break;
    }
  }
  if (!view.depth) return view;
  view.camera = unknown_camera(view.depth->file);
  if (options.intrinsics) view.camera->intrinsics = *options.intrinsics;
  return view;
}

Result<FolderGuess> guess_from_images(const fs::path& folder, const ReadProjectOptions& options,
                                      const std::string& why_not_read) {
  std::map<std::string, std::vector<NamedImage>, NaturalOrder> by_view;
  for (NamedImage& image : images_in(folder)) by_view[image.view].push_back(std::move(image));
  FolderGuess guess;
  const CamerasByView cameras = listed_cameras(folder, guess);
  bool whole_numbers = false, without_camera = false;
  for (const auto& [name, images] : by_view) {
    ViewSpec view = guessed_view(name, images, options);
    take_listed_camera(cameras, view);
    if (!view.depth) {
      for (const NamedImage& image : images)
        guess.findings.push_back("left out " + image.file.string() +
                                 ": no depth map has the rest of its name, '" + name + "'");
      continue;
    }
    whole_numbers |= holds_whole_numbers(view.depth->file);
    without_camera |= !options.intrinsics && !cameras.contains(name);
    guess.project.views.push_back(std::move(view));
  }
  if (guess.project.views.empty())
    return bad_input(folder,
                     "no file in it can be a scan: names of depth maps have the word "
                     "'depth' or 'range', or they are PNG of 16 grey bits; grids and points end in "
                     ".ply, .pcd, .ptx, .e57, "
                     ".xyz or .pts. (" +
                         why_not_read + ")");
  guess.project.unit = whole_numbers ? "mm" : "units";
  if (without_camera)
    guess.missing.push_back("fx and fy of each camera [pixels]; cx and cy are set to the middle");
  if (whole_numbers && !options.depth_scale)
    guess.missing.push_back(
        "the scale of the depth maps: their value times the scale is in the unit; 1 was taken, as "
        "for whole millimetres");
  guess.missing.push_back("where known: the pose of each view as \"world_from_view\" (4 x 4)");
  return guess;
}

void put_comment(const std::string& text, std::string& out) {
  out += "// ";
  for (const char c : text) out += c == '\n' ? ' ' : c;
  out += '\n';
}

}  // namespace

Result<FolderGuess> guess_project(const fs::path& folder, const ReadProjectOptions& options) {
  std::error_code code;
  if (!fs::is_directory(folder, code)) return bad_input(folder, "is no folder");
  auto project = read_project_spec(folder, options);
  if (!project) {
    const std::string& why_not_read = project.error().message;
    auto from_images = guess_from_images(folder, options, why_not_read);
    if (from_images)
      from_images->findings.insert(from_images->findings.begin(),
                                   "not read as it is: " + why_not_read);
    return from_images;
  }
  FolderGuess guess;
  guess.project = std::move(*project);
  for (const std::string& note : guess.project.notes) guess.findings.push_back(note);
  guess.findings.push_back("all of it is read as it is; this file is for changes");
  return guess;
}

Result<ProjectSpec> read_depth_maps(const fs::path& folder, const ReadProjectOptions& options) {
  auto guess = guess_from_images(folder, options, "no list or calibration is beside the images");
  if (!guess) return guess.error();
  const auto whole_numbers = [](const ViewSpec& view) {
    return holds_whole_numbers(view.depth->file);
  };
  std::vector<ViewSpec>& views = guess->project.views;
  const bool assumes =
      !options.depth_scale && std::any_of(views.begin(), views.end(), whole_numbers);
  if (assumes) {
    auto assumed = assume_depth_scale(guess->project, kMillimetres, ComparedDepths(guess->project));
    if (!assumed)
      return bad_input(folder,
                       "its depth maps hold whole numbers: give --depth-scale, their steps to the "
                       "unit, as 1000 to the metre");
    for (ViewSpec& view : views)
      if (whole_numbers(view)) view.depth->scale = assumed->metres_per_value;
    guess->findings.push_back(std::move(assumed->note));
  }
  if (assumes || options.depth_scale) guess->project.unit = "m";
  guess->project.notes = std::move(guess->findings);
  return std::move(guess->project);
}

std::string commented_scan_json(const FolderGuess& guess, const fs::path& folder) {
  std::string text;
  put_comment("Found " + std::to_string(guess.project.views.size()) + " views.", text);
  for (const std::string& line : guess.findings) put_comment(line, text);
  for (const std::string& line : guess.missing) put_comment("TO FILL IN: " + line, text);
  auto document = empty_project_json(guess.project.unit);
  for (const ViewSpec& view : guess.project.views)
    document["views"].push_back(view_json(view, folder));
  return text + document.dump(1) + "\n";
}

}  // namespace relief
