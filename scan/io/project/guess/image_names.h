#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace relief {

/// What an image of a view is.
enum class ImageRole { kDepth, kNormals, kMask, kConfidence, kColour };

/// An image and what its name tells.
struct NamedImage {
  std::filesystem::path file;
  ImageRole role = ImageRole::kDepth;
  std::string view;
  bool of_own_folder = false;  ///< Its folder tells the view.
};

/// The view that the name of an image tells: what is left of it without the word of its role, in
/// lower case: `owl_01` of `Owl01_depth.png`; `view` where nothing is.
std::string view_of_name(const std::filesystem::path& file);

/// The images of a folder and of the folders in it whose names, or else whose folders' names, tell
/// their role (`depth`, `normal`, `mask`), in the order of their names. A file that is called by
/// its role alone is of the view of its folder: `view_0/depth.png`. Where no name tells a depth
/// map, PNG of 16 grey bits are, and other images of the same name have their colours.
std::vector<NamedImage> named_images(const std::filesystem::path& folder);

}  // namespace relief
