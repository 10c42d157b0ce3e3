#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"

class vtkXMLDataElement;

namespace relief {

/// A VTK XML file whose elements VTK has read, and whose arrays are decoded here: VTK's own decoder
/// crashes on damaged files. Known are all number types, ASCII, base64 and raw data, inline or
/// appended, of either byte order, compressed by zlib or not.
class VtpFile {
 public:
  /// kBadInput for what is no well-formed XML up to the appended data, and for another compressor.
  /// `path` is for messages only.
  static Result<VtpFile> parse(std::string content, std::filesystem::path path);
  ~VtpFile();
  VtpFile(VtpFile&&) noexcept;

  vtkXMLDataElement& root() const;
  const std::filesystem::path& path() const { return path_; }

  /// How many bytes of numbers a file of this size can hold, compressed ones among them.
  std::size_t most_values() const;

  /// The `count` numbers of a DataArray element. kBadInput when it holds another number of them or
  /// is damaged; nothing is allocated that the file cannot fill.
  Result<std::vector<double>> values(vtkXMLDataElement& array, std::size_t count) const;

 private:
  struct Elements;
  explicit VtpFile(std::string content, std::filesystem::path path);
  Error damaged(vtkXMLDataElement& array, const std::string& what) const;
  Result<std::string> bytes_of(vtkXMLDataElement& array, std::string_view data, bool base64,
                               std::size_t count) const;
  std::string compressed_header(std::string_view data, bool base64, std::size_t count) const;
  Result<std::string_view> data_of(vtkXMLDataElement& array, bool appended) const;
  Result<std::string> inflated(vtkXMLDataElement& array, std::string_view data, bool base64,
                               std::size_t count) const;
  std::string_view inline_text(vtkXMLDataElement& array) const;
  std::size_t size_at(std::string_view bytes, std::size_t index) const;

  std::string content_;
  std::filesystem::path path_;
  std::unique_ptr<Elements> elements_;
  std::size_t size_bytes_ = 4;  // Of a size in the headers of arrays.
  bool swap_ = false, compressed_ = false, appended_base64_ = false;
  std::size_t appended_ = std::string::npos;  // Where the appended data begin.
};

}  // namespace relief
