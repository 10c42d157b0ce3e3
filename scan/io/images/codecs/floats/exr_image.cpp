#include <cstring>
#include <exception>
#include <optional>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/codecs/floats/exr_header.h"
#include "scan/io/images/image_io.h"

namespace relief {

namespace {

namespace exr = OPENEXR_IMF_NAMESPACE;

class MemoryStream : public exr::IStream {
 public:
  MemoryStream(std::string_view content, const std::string& name)
      : IStream(name.c_str()), content_(content) {}

  bool read(char buffer[], int count) override {
    const auto length = static_cast<std::size_t>(count);
    if (count < 0 || position_ > content_.size() || length > content_.size() - position_)
      throw std::runtime_error("the file is truncated");
    std::memcpy(buffer, content_.data() + position_, length);
    position_ += length;
    return position_ < content_.size();
  }
  std::uint64_t tellg() override { return position_; }
  void seekg(std::uint64_t position) override { position_ = position; }

 private:
  std::string_view content_;
  std::size_t position_ = 0;
};

// The channels to read: three that form a vector, or the one that is a depth.
std::vector<std::string> choose_channels(const exr::ChannelList& channels) {
  const auto has = [&](const char* name) { return channels.findChannel(name) != nullptr; };
  if (has("R") && has("G") && has("B")) return {"R", "G", "B"};
  if (has("X") && has("Y") && has("Z")) return {"X", "Y", "Z"};
  for (const char* name : {"Z", "Y", "R"})
    if (has(name)) return {name};
  const auto first = channels.begin();
  if (first == channels.end()) return {};
  auto second = first;
  return ++second == channels.end() ? std::vector<std::string>{first.name()}
                                    : std::vector<std::string>{};
}

// Reads into the data window, which becomes the image: the display window is for viewers.
Result<Image> read_exr(exr::IStream& stream, const std::filesystem::path& path) {
  exr::InputFile file(stream);
  const auto window = file.header().dataWindow();
  const std::vector<std::string> names = choose_channels(file.header().channels());
  if (names.empty())
    return bad_input(path, "no channel to read: a depth is in Z, Y or R, a normal in R, G and B");
  const auto width = static_cast<std::int64_t>(window.max.x) - window.min.x + 1;
  const auto height = static_cast<std::int64_t>(window.max.y) - window.min.y + 1;
  Image image(static_cast<int>(width), static_cast<int>(height), static_cast<int>(names.size()));
  exr::FrameBuffer frame;
  for (std::size_t c = 0; c < names.size(); ++c) {
    const auto* channel = file.header().channels().findChannel(names[c].c_str());
    if (channel->xSampling != 1 || channel->ySampling != 1)
      return bad_input(path, "channel " + names[c] + " is subsampled; store every pixel");
    frame.insert(
        names[c],
        exr::Slice::Make(exr::FLOAT, image.samples.data() + c, window, sizeof(float) * names.size(),
                         sizeof(float) * names.size() * static_cast<std::size_t>(width)));
  }
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);
  return image;
}

}  // namespace

Result<Image> decode_exr(std::string_view content, const std::filesystem::path& path) {
  if (auto checked = check_exr_headers(content, path); !checked) return checked.error();
  try {
    MemoryStream stream(content, path.string());
    return read_exr(stream, path);
  } catch (const std::exception& exception) {
    return bad_input(path, std::string("damaged or unsupported OpenEXR: ") + exception.what());
  }
}

}  // namespace relief
