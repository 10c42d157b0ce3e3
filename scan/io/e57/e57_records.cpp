#include "scan/io/e57/e57_records.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "scan/io/files/io_error.h"

namespace relief {

namespace {

constexpr std::uint64_t kSectionHeaderBytes = 32;
constexpr std::uint64_t kPacketHeaderBytes = 4;      // type, flags, length less one
constexpr std::uint64_t kDataPacketHeaderBytes = 6;  // and the number of bytestreams
constexpr int kSectionId = 1;                        // of a compressed vector
constexpr int kIndexPacket = 0, kDataPacket = 1, kEmptyPacket = 2;
constexpr std::size_t kBatch = 4096;  // values at once
constexpr std::size_t kSlack = 9;     // bytes past the end that loading 64 bits may touch

// Unpacks one bytestream, which runs on from packet to packet.
class FieldDecoder {
 public:
  FieldDecoder(const E57Field& field, const E57Sink& sink, std::size_t records)
      : field_(&field), sink_(&sink), records_(records) {}

  const std::string& name() const { return field_->name; }
  std::size_t decoded() const { return decoded_; }
  bool done() const { return decoded_ == records_; }

  void feed(std::string_view bytes) {
    if (done()) return;
    pending_.resize(pending_.size() - slack_);
    pending_.append(bytes);
    const std::size_t bits = pending_.size() * 8;
    pending_.append(kSlack, '\0');
    slack_ = kSlack;
    while (!done() && decode_batch(bits)) {
    }
    drop_decoded();
  }

 private:
  // Nothing more to decode: false.
  bool decode_batch(std::size_t bits) {
    const auto width = static_cast<std::size_t>(field_->bits);
    std::size_t count = std::min(kBatch, records_ - decoded_);
    if (width > 0) count = std::min(count, (bits - bit_) / width);
    if (count == 0) return false;
    values_.resize(count);
    switch (field_->type) {
      case E57Field::Type::kFloat:
        unpack([](std::uint64_t raw) {
          return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
        });
        break;
      case E57Field::Type::kDouble:
        unpack([](std::uint64_t raw) { return std::bit_cast<double>(raw); });
        break;
      case E57Field::Type::kInteger:
        unpack([this](std::uint64_t raw) { return scaled(raw); });
        break;
      case E57Field::Type::kText:
        break;
    }
    (*sink_)(decoded_, values_);
    decoded_ += count;
    return true;
  }

  // Modulo 2^64, as the bits of any file may say.
  double scaled(std::uint64_t raw) const {
    const auto integer =
        static_cast<std::int64_t>(raw + static_cast<std::uint64_t>(field_->minimum));
    return static_cast<double>(integer) * field_->scale + field_->offset;
  }

  template <typename Convert>
  void unpack(const Convert& convert) {
    const auto width = static_cast<unsigned>(field_->bits);
    const std::uint64_t mask =
        width == 0 ? 0 : std::numeric_limits<std::uint64_t>::max() >> (64 - width);
    for (double& value : values_) {
      const char* bytes = pending_.data() + bit_ / 8;
      const unsigned shift = static_cast<unsigned>(bit_ % 8);
      std::uint64_t raw = e57_number_at<std::uint64_t>(bytes) >> shift;
      if (width + shift > 64)
        raw |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[8])) << (64 - shift);
      value = convert(raw & mask);
      bit_ += width;
    }
  }

  void drop_decoded() {
    pending_.erase(0, bit_ / 8);
    bit_ %= 8;
  }

  const E57Field* field_;
  const E57Sink* sink_;
  std::size_t records_;
  std::size_t decoded_ = 0;
  std::size_t bit_ = 0;    // of `pending_`, the next one
  std::string pending_;    // bytes that are not decoded yet, and the slack
  std::size_t slack_ = 0;  // bytes at the end of `pending_` that are not the stream's
  std::vector<double> values_;
};

// Walks over the packets of a scan's section.
class RecordReader {
 public:
  RecordReader(E57Pages& pages, const E57Scan& scan, const std::vector<E57Target>& targets)
      : pages_(pages), scan_(scan), decoders_(scan.fields.size()) {
    for (const E57Target& target : targets)
      for (std::size_t i = 0; i < scan.fields.size(); ++i)
        if (&scan.fields[i] == scan.find(target.field))
          decoders_[i].emplace(scan.fields[i], target.sink, scan.record_count);
  }

  Result<void> read() {
    if (auto header = read_section_header(); !header) return header;
    if (scan_.record_count == 0) return {};
    for (auto& decoder : decoders_)
      if (decoder) decoder->feed({});  // fields of no bits are complete without any packet
    while (!done() && at_ + kPacketHeaderBytes <= end_)
      if (auto packet = read_packet(); !packet) return packet;
    return check_complete();
  }

 private:
  Error damaged(std::uint64_t logical, const std::string& what) const {
    return bad_input(pages_.path(), "damaged E57, byte " + std::to_string(e57_physical(logical)) +
                                        " (page " + std::to_string(logical / kE57PayloadBytes) +
                                        "): " + what);
  }

  bool done() const {
    return std::all_of(decoders_.begin(), decoders_.end(),
                       [](const auto& decoder) { return !decoder || decoder->done(); });
  }

  Result<void> read_section_header() {
    const auto start = pages_.logical_offset(scan_.section_offset, "the section of points");
    if (!start) return start.error();
    const auto header = pages_.read(*start, kSectionHeaderBytes, "the header of the points");
    if (!header) return header.error();
    const int id = static_cast<unsigned char>(header->front());
    const auto length = e57_number_at<std::uint64_t>(header->data() + 8);
    const auto data = e57_number_at<std::uint64_t>(header->data() + 16);
    if (id != kSectionId)
      return damaged(*start, "a section of points begins with 1, not with " + std::to_string(id) +
                                 "; export the file again");
    if (length > pages_.payload_bytes() - *start)
      return damaged(*start, "the section of points has a length of " + std::to_string(length) +
                                 " bytes, more than the file has left");
    end_ = *start + length;
    if (scan_.record_count == 0) return {};
    const auto first = pages_.logical_offset(data, "the first packet of the points");
    if (!first) return first.error();
    at_ = *first;
    return {};
  }

  Result<void> read_packet() {
    const auto header = pages_.read(at_, kPacketHeaderBytes, "the header of a packet");
    if (!header) return header.error();
    const int type = static_cast<unsigned char>(header->front());
    const std::uint64_t length = 1u + e57_number_at<std::uint16_t>(header->data() + 2);
    if (type != kIndexPacket && type != kDataPacket && type != kEmptyPacket)
      return damaged(at_, "a packet of the unknown type " + std::to_string(type));
    if (length % 4 != 0 || length > end_ - at_)
      return damaged(
          at_, "a packet of " + std::to_string(length) + " bytes, which does not fit its section");
    if (type == kDataPacket)
      if (auto data = read_data_packet(length); !data) return data;
    at_ += length;
    return {};
  }

  Result<void> read_data_packet(std::uint64_t length) {
    const auto packet = pages_.read(at_, length, "a data packet");
    if (!packet) return packet.error();
    const std::uint64_t streams =
        length < kDataPacketHeaderBytes ? 0 : e57_number_at<std::uint16_t>(packet->data() + 4);
    if (streams != decoders_.size())
      return damaged(at_, "a data packet of " + std::to_string(streams) +
                              " bytestreams for points of " + std::to_string(decoders_.size()) +
                              " fields");
    std::uint64_t begin = kDataPacketHeaderBytes + 2 * streams;
    if (begin > length) return damaged(at_, "a data packet shorter than its own header");
    for (std::size_t i = 0; i < decoders_.size(); ++i) {
      const char* place = packet->data() + kDataPacketHeaderBytes + 2 * i;
      const std::uint64_t bytes = e57_number_at<std::uint16_t>(place);
      if (bytes > length - begin)
        return damaged(at_, "the bytestream of " + scan_.fields[i].name + " has " +
                                std::to_string(bytes) + " bytes, more than its packet");
      if (decoders_[i]) decoders_[i]->feed(packet->substr(begin, bytes));
      begin += bytes;
    }
    return {};
  }

  Result<void> check_complete() const {
    for (const auto& decoder : decoders_)
      if (decoder && !decoder->done())
        return damaged(at_, "the packets end after " + std::to_string(decoder->decoded()) + " of " +
                                std::to_string(scan_.record_count) + " values of " +
                                decoder->name() + "; the file is truncated or was not finished");
    return {};
  }

  E57Pages& pages_;
  const E57Scan& scan_;
  std::vector<std::optional<FieldDecoder>> decoders_;  // of each field that is wanted
  std::uint64_t at_ = 0, end_ = 0;                     // logical
};

}  // namespace

Result<void> check_e57_record_count(const E57Pages& pages, const E57Scan& scan) {
  std::uint64_t bits = 1;  // records of no bits at all must not be without end
  for (const E57Field& field : scan.fields)
    if (field.type != E57Field::Type::kText) bits += static_cast<std::uint64_t>(field.bits);
  bits = std::max<std::uint64_t>(bits - 1, 1);
  if (scan.record_count <= pages.payload_bytes() * 8 / bits) return {};
  return bad_input(pages.path(), "the E57 promises " + std::to_string(scan.record_count) +
                                     " points of " + std::to_string(bits) +
                                     " bits each, more than the file can hold; it is truncated "
                                     "or its XML section is wrong");
}

Result<void> read_e57_records(E57Pages& pages, const E57Scan& scan,
                              const std::vector<E57Target>& targets) {
  return RecordReader(pages, scan, targets).read();
}

}  // namespace relief
