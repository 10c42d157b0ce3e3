#include "scan/io/meshes/vtp_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>

#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <zlib.h>

#include "scan/io/files/io_error.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

// Elements are freed one inside the other: their number bounds their depth.
constexpr std::ptrdiff_t kMostTags = 10000;

std::string attribute(vtkXMLDataElement& element, const char* name) {
  const char* text = element.GetAttribute(name);
  return text ? text : "";
}

// -1: not of the alphabet.
int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// The bytes of the groups of four characters up to the first that ends the data, `most` at most.
std::string decode_base64(std::string_view text, std::size_t most) {
  std::string bytes;
  for (std::size_t i = 0; i + 4 <= text.size() && bytes.size() < most; i += 4) {
    std::uint32_t bits = 0;
    int count = 0;
    for (; count < 4 && base64_value(text[i + static_cast<std::size_t>(count)]) >= 0; ++count)
      bits = bits << 6 |
             static_cast<std::uint32_t>(base64_value(text[i + static_cast<std::size_t>(count)]));
    bits <<= 6 * (4 - count);
    for (int k = 0; k + 1 < count; ++k) bytes += static_cast<char>(bits >> (16 - 8 * k));
    if (count < 4) break;
  }
  bytes.resize(std::min(bytes.size(), most));
  return bytes;
}

constexpr std::size_t base64_characters(std::size_t bytes) { return (bytes + 2) / 3 * 4; }

template <typename T>
T number_at(std::string_view bytes, std::size_t index, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes.data() + index * sizeof(T), sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

template <typename T>
std::vector<double> numbers_of(std::string_view bytes, bool swap) {
  std::vector<double> numbers(bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = static_cast<double>(number_at<T>(bytes, i, swap));
  return numbers;
}

struct NumberType {
  const char* name;
  std::size_t bytes;
  std::vector<double> (*decode)(std::string_view bytes, bool swap);
};

constexpr std::array<NumberType, 10> kTypes{{{"Int8", 1, numbers_of<std::int8_t>},
                                             {"UInt8", 1, numbers_of<std::uint8_t>},
                                             {"Int16", 2, numbers_of<std::int16_t>},
                                             {"UInt16", 2, numbers_of<std::uint16_t>},
                                             {"Int32", 4, numbers_of<std::int32_t>},
                                             {"UInt32", 4, numbers_of<std::uint32_t>},
                                             {"Int64", 8, numbers_of<std::int64_t>},
                                             {"UInt64", 8, numbers_of<std::uint64_t>},
                                             {"Float32", 4, numbers_of<float>},
                                             {"Float64", 8, numbers_of<double>}}};

const NumberType* type_of(vtkXMLDataElement& array) {
  const std::string name = attribute(array, "type");
  for (const NumberType& type : kTypes)
    if (name == type.name) return &type;
  return nullptr;
}

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

std::vector<double> ascii_numbers(std::string_view text, std::size_t most) {
  std::vector<double> numbers;
  const char *at = text.data(), *end = at + text.size();
  while (numbers.size() <= most) {
    while (at != end && is_space(*at)) ++at;
    double value = 0.0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc()) break;
    numbers.push_back(value);
    at = read.ptr;
  }
  return numbers;
}

// Whether the first `size` bytes of `packed` inflate to exactly `whole` bytes.
bool inflate_block(std::string_view packed, std::size_t size, char* bytes, std::size_t whole) {
  uLongf length = whole;
  return size <= packed.size() &&
         uncompress(reinterpret_cast<Bytef*>(bytes), &length,
                    reinterpret_cast<const Bytef*>(packed.data()), size) == Z_OK &&
         length == whole;
}

}  // namespace

struct VtpFile::Elements {
  std::istringstream stream;
  vtkNew<vtkXMLDataParser> parser;
};

VtpFile::VtpFile(std::string content, std::filesystem::path path)
    : content_(std::move(content)), path_(std::move(path)), elements_(new Elements) {}
VtpFile::~VtpFile() = default;
VtpFile::VtpFile(VtpFile&&) noexcept = default;

vtkXMLDataElement& VtpFile::root() const { return *elements_->parser->GetRootElement(); }

std::size_t VtpFile::most_values() const { return kDeflate * content_.size(); }

Result<VtpFile> VtpFile::parse(std::string content, std::filesystem::path path) {
  VtpFile file(std::move(content), std::move(path));
  const std::string_view head =
      std::string_view(file.content_).substr(0, file.content_.find("<AppendedData"));
  if (std::count(head.begin(), head.end(), '<') > kMostTags)
    return bad_input(file.path_, "a VTP of more than " + std::to_string(kMostTags) + " tags");
  file.elements_->stream.str(file.content_);
  file.elements_->parser->SetStream(&file.elements_->stream);
  if (file.elements_->parser->Parse() != 1 || !file.elements_->parser->GetRootElement())
    return bad_input(file.path_, "damaged VTP: no well-formed XML");
  const std::string compressor = attribute(file.root(), "compressor");
  file.compressed_ = compressor == "vtkZLibDataCompressor";
  if (!compressor.empty() && !file.compressed_)
    return bad_input(file.path_,
                     "compressed by " + compressor + "; save it with zlib or without compression");
  file.size_bytes_ = attribute(file.root(), "header_type") == "UInt64" ? 8 : 4;
  file.swap_ = (attribute(file.root(), "byte_order") == "BigEndian") !=
               (std::endian::native == std::endian::big);
  if (auto* appended = file.root().FindNestedElementWithName("AppendedData")) {
    file.appended_base64_ = attribute(*appended, "encoding") != "raw";
    const std::size_t mark =
        file.content_.find('_', file.content_.find('>', file.content_.find("<AppendedData")));
    if (mark != std::string::npos) file.appended_ = mark + 1;
  }
  return file;
}

Error VtpFile::damaged(vtkXMLDataElement& array, const std::string& what) const {
  return bad_input(path_, "damaged VTP: array '" + attribute(array, "Name") + "': " + what);
}

std::string_view VtpFile::inline_text(vtkXMLDataElement& array) const {
  const auto start = static_cast<std::size_t>(std::max<vtkTypeInt64>(0, array.GetXMLByteIndex()));
  const std::size_t begin = content_.find('>', start);
  if (begin == std::string::npos) return {};
  const std::string_view text = std::string_view(content_).substr(begin + 1);
  return text.substr(0, text.find('<'));
}

std::size_t VtpFile::size_at(std::string_view bytes, std::size_t index) const {
  return size_bytes_ == 8 ? number_at<std::uint64_t>(bytes, index, swap_)
                          : number_at<std::uint32_t>(bytes, index, swap_);
}

// Where the data of an array begin.
Result<std::string_view> VtpFile::data_of(vtkXMLDataElement& array, bool appended) const {
  if (appended) {
    const auto offset = std::strtoull(attribute(array, "offset").c_str(), nullptr, 10);
    if (appended_ == std::string::npos || offset > content_.size() - appended_)
      return damaged(array, "its offset lies outside the appended data");
    return std::string_view(content_).substr(appended_ + offset);
  }
  std::string_view data = inline_text(array);
  while (!data.empty() && is_space(data.front())) data.remove_prefix(1);
  return data;
}

Result<std::vector<double>> VtpFile::values(vtkXMLDataElement& array, std::size_t count) const {
  const NumberType* type = type_of(array);
  if (!type) return damaged(array, "unknown type '" + attribute(array, "type") + "'");
  if (count == 0) return std::vector<double>();
  const std::string format = attribute(array, "format");
  const bool binary = format == "appended" || format == "binary";
  if (count > most_values() / (binary ? type->bytes : 1))
    return damaged(array, "more numbers than the file can hold");
  const auto data = data_of(array, format == "appended");
  if (!data) return data.error();
  if (!binary) {
    auto numbers = ascii_numbers(*data, count);
    if (numbers.size() == count) return numbers;
    return damaged(array,
                   std::to_string(numbers.size()) + " numbers, not " + std::to_string(count));
  }
  const auto bytes =
      bytes_of(array, *data, format != "appended" || appended_base64_, count * type->bytes);
  if (!bytes) return bytes.error();
  return type->decode(*bytes, swap_);
}

Result<std::string> VtpFile::bytes_of(vtkXMLDataElement& array, std::string_view data, bool base64,
                                      std::size_t count) const {
  if (compressed_) return inflated(array, data, base64, count);
  const std::string bytes = base64 ? decode_base64(data, size_bytes_ + count)
                                   : std::string(data.substr(0, size_bytes_ + count));
  if (bytes.size() != size_bytes_ + count || size_at(bytes, 0) != count)
    return damaged(array, "it is not of the promised size");
  return bytes.substr(size_bytes_);
}

// Compressed data: the number of blocks, their size, that of the last one if it is shorter, and the
// compressed size of each; then the blocks.
std::string VtpFile::compressed_header(std::string_view data, bool base64,
                                       std::size_t count) const {
  const auto first = [&](std::size_t bytes) {
    std::string decoded = base64 ? decode_base64(data, bytes) : std::string(data.substr(0, bytes));
    return decoded.size() == bytes ? decoded : std::string();
  };
  const std::string sizes = first(3 * size_bytes_);
  if (sizes.empty()) return {};
  const std::size_t blocks = size_at(sizes, 0), block = size_at(sizes, 1), last = size_at(sizes, 2);
  const bool fits = blocks > 0 && blocks <= data.size() / size_bytes_ && last <= block &&
                    (blocks == 1 || block <= count / (blocks - 1)) &&
                    (blocks - 1) * block + (last > 0 ? last : block) == count;
  return fits ? first((3 + blocks) * size_bytes_) : std::string();
}

Result<std::string> VtpFile::inflated(vtkXMLDataElement& array, std::string_view data, bool base64,
                                      std::size_t count) const {
  const std::string header = compressed_header(data, base64, count);
  if (header.empty()) return damaged(array, "it is not of the promised size");
  const std::size_t blocks = size_at(header, 0), block = size_at(header, 1),
                    last = size_at(header, 2);
  data.remove_prefix(
      std::min(data.size(), base64 ? base64_characters(header.size()) : header.size()));
  std::size_t packed_size = 0;
  for (std::size_t i = 0; i < blocks && packed_size <= data.size(); ++i)
    packed_size += std::min(size_at(header, 3 + i), data.size() + 1);
  const std::string decoded =
      base64 ? decode_base64(data, std::min(packed_size, data.size())) : std::string();
  std::string_view packed = base64 ? std::string_view(decoded) : data;
  std::string bytes(count, '\0');
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::size_t size = size_at(header, 3 + i);
    const std::size_t whole = i + 1 == blocks && last > 0 ? last : block;
    if (!inflate_block(packed, size, bytes.data() + i * block, whole))
      return damaged(array, "its compressed data are damaged");
    packed.remove_prefix(size);
  }
  return bytes;
}

}  // namespace relief
