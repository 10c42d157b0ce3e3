#include "apps/console/picture_file.h"

#include "scan/io/files/atomic_file.h"
#include "scan/io/images/image_io.h"

namespace relief {

Result<std::string> png_of(const rendering::Picture& picture, rendering::Background background,
                           const std::string& description) {
  const int channels = background == rendering::Background::kTransparent ? 4 : 3;
  Image image(picture.width(), picture.height(), channels, 255.0);
  for (int v = 0; v < picture.height(); ++v)
    for (int u = 0; u < picture.width(); ++u)
      for (int k = 0; k < channels; ++k)
        image(u, v, k) = picture(u, v)[static_cast<std::size_t>(k)];
  return encode_png(image, {{"Software", "relief"}, {"Description", description}});
}

Result<void> write_picture(const rendering::Picture& picture, rendering::Background background,
                           const std::string& description, const std::filesystem::path& path) {
  const auto content = png_of(picture, background, description);
  if (!content)
    return Error{ErrorKind::kCannotWrite, path.string() + ": " + content.error().message};
  return write_file(path, *content);
}

}  // namespace relief
