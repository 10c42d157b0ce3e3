#include "scan/io/project/guess/image_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <optional>
#include <utility>

#include "scan/io/files/file_ending.h"
#include "scan/io/files/folder_files.h"
#include "scan/io/images/image_size.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

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

const char* const kOnlyView = "view";  // Of a view that no name tells.

ImageName name_in(const std::string& text) {
  ImageName name;
  for (const std::string& word : words_of(lower_case(text))) {
    const auto found = role_of_word(word);
    if (found && !name.role) {
      name.role = found;
      continue;
    }
    name.view += (name.view.empty() ? "" : "_") + word;
  }
  return name;
}

// The role is told by the name of the file, else by that of its folder, where single letters say
// nothing.
std::optional<NamedImage> named_image(const fs::path& file, const std::string& folder_name) {
  ImageName name = name_in(file.stem().string());
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

bool has_depth(const std::vector<NamedImage>& images) {
  return std::ranges::any_of(
      images, [](const NamedImage& image) { return image.role == ImageRole::kDepth; });
}

// `folder_view`: the view of images that are called by their role alone, if one is a depth map.
std::vector<NamedImage> images_of_folder(const fs::path& folder, const std::string& folder_name,
                                         const std::string& folder_view) {
  std::vector<NamedImage> images;
  for (const fs::path& file : files_in(folder))
    if (is_image(file))
      if (auto image = named_image(file, folder_name)) images.push_back(std::move(*image));
  const bool is_of_one_view = !folder_view.empty() && has_depth(images);
  for (NamedImage& image : images) {
    if (!image.view.empty()) continue;
    image.view = is_of_one_view ? folder_view : kOnlyView;
    image.of_own_folder = is_of_one_view;
  }
  return images;
}

// Where no name tells depth maps: `7.png` of 16 grey bits is one, and `7.jpg` has its colours.
std::vector<NamedImage> images_by_their_bits(const fs::path& folder) {
  std::vector<NamedImage> images;
  for (const fs::path& file : files_in(folder)) {
    const ImageName name = name_in(file.stem().string());
    if (!is_image(file) || (name.role && name.role != ImageRole::kColour)) continue;
    const bool depth = !name.role && is_grey_16_bit_png(file);
    images.push_back({file, depth ? ImageRole::kDepth : ImageRole::kColour, view_of_name(file)});
  }
  return has_depth(images) ? images : std::vector<NamedImage>();
}

}  // namespace

std::string view_of_name(const fs::path& file) {
  const std::string view = name_in(file.stem().string()).view;
  return view.empty() ? kOnlyView : view;
}

std::vector<NamedImage> named_images(const fs::path& folder) {
  std::error_code code;
  auto images =
      images_of_folder(folder, fs::weakly_canonical(folder, code).filename().string(), "");
  for (const fs::path& below : folders_in(folder)) {
    const std::string name = below.filename().string();  // `depth`, or `view_0`.
    std::ranges::move(images_of_folder(below, name, name_in(name).view),
                      std::back_inserter(images));
  }
  if (!has_depth(images))
    if (auto by_bits = images_by_their_bits(folder); !by_bits.empty()) images = std::move(by_bits);
  std::sort(images.begin(), images.end(), [](const auto& a, const auto& b) {
    return natural_less(a.file.native(), b.file.native());
  });
  return images;
}

}  // namespace relief
