#include "scan/io/e57/e57_section_writer.h"

#include <algorithm>
#include <cstdint>

#include "scan/io/e57/e57_layout.h"
#include "scan/io/e57/e57_pages.h"
#include "scan/io/files/binary_writer.h"

namespace relief {

namespace {

// A multiple of 64, so that each bytestream of a full packet ends with a whole 64-bit word; and few
// enough that a packet stays below the 64 KiB of the standard.
constexpr std::size_t kRecordsPerPacket = 1024;
constexpr std::size_t kSectionHeaderLength = 32;
constexpr std::size_t kIndexPacketLength = 32;  // a header and one entry

// Integers of `bits` bits, least significant bit first, filled up to whole 64-bit words.
template <typename Value>
std::string packed_bits(std::size_t count, int bits, const Value& value) {
  std::string bytes;
  std::uint64_t word = 0;
  int filled = 0;
  for (std::size_t i = 0; i < count && bits > 0; ++i) {
    const auto integer = static_cast<std::uint64_t>(value(i));
    word |= integer << filled;
    filled += bits;
    if (filled < 64) continue;
    append_little_endian(bytes, word);
    filled -= 64;
    word = filled > 0 ? integer >> (bits - filled) : 0;
  }
  if (filled > 0) append_little_endian(bytes, word);
  return bytes;
}

// The bytestreams of the records from `first` on.
std::vector<std::string> streams_of(const E57RecordPlan& plan, std::size_t first,
                                    std::size_t count) {
  const RangeView& view = *plan.view;
  std::vector<std::string> streams(3);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d point = plan.point(first + i);
    for (int k = 0; k < 3; ++k)
      append_little_endian(streams[static_cast<std::size_t>(k)], point[k]);
  }
  const auto pixel = [&](std::size_t i) { return plan.pixels[first + i]; };
  streams.push_back(packed_bits(count, e57_bits_between(0, view.height() - 1),
                                [&](auto i) { return pixel(i)[1]; }));
  streams.push_back(packed_bits(count, e57_bits_between(0, view.width() - 1),
                                [&](auto i) { return pixel(i)[0]; }));
  for (std::size_t k = 0; k < 3 && !view.colours.empty(); ++k) {
    streams.emplace_back();
    for (std::size_t i = 0; i < count; ++i)
      streams.back() += static_cast<char>(view.colours(pixel(i)[0], pixel(i)[1])[k]);
  }
  for (int k = 0; k < 3 && view.has_normals(); ++k) {
    streams.emplace_back();
    for (std::size_t i = 0; i < count; ++i) {
      const auto [u, v] = pixel(i);
      // Other programs expect numbers: a vector of length 0 stands for no normal.
      append_little_endian(streams.back(), view.has_normal(u, v) ? view.normals(u, v)[k] : 0.0f);
    }
  }
  return streams;
}

std::string data_packet(const std::vector<std::string>& streams) {
  std::string body;
  append_little_endian(body, static_cast<std::uint16_t>(streams.size()));
  for (const std::string& stream : streams)
    append_little_endian(body, static_cast<std::uint16_t>(stream.size()));
  for (const std::string& stream : streams) body += stream;
  body.resize((body.size() + 3) / 4 * 4, '\0');  // with the 4 bytes of type, flags and length
  std::string packet{1, 0};
  append_little_endian(packet, static_cast<std::uint16_t>(body.size() + 3));
  return packet + body;
}

// One entry: record 0 is in the packet at `first_packet` (physical).
std::string index_packet(std::uint64_t first_packet) {
  std::string packet{0, 0};
  append_little_endian(packet, static_cast<std::uint16_t>(kIndexPacketLength - 1));
  append_little_endian(packet, std::uint16_t{1});
  packet.resize(16, '\0');  // the level, 0, and reserved bytes
  append_little_endian(packet, std::uint64_t{0});
  append_little_endian(packet, first_packet);
  return packet;
}

}  // namespace

E57RecordPlan plan_e57_records(const RangeView& view, double metres_per_unit) {
  E57RecordPlan plan;
  plan.view = &view;
  plan.metres_per_unit = metres_per_unit;
  plan.pixels.reserve(view.sample_count());
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) plan.pixels.push_back({u, v});
  for (std::size_t i = 0; i < plan.pixels.size(); ++i) {
    const Eigen::Vector3d point = plan.point(i);
    plan.low = i == 0 ? point : Eigen::Vector3d(plan.low.cwiseMin(point));
    plan.high = i == 0 ? point : Eigen::Vector3d(plan.high.cwiseMax(point));
  }
  return plan;
}

void append_e57_section(std::string& payload, const E57RecordPlan& plan) {
  const std::size_t start = payload.size();
  payload.resize(start + kSectionHeaderLength, '\0');
  std::size_t first = 0;
  do {  // a scan without points has one packet too, which readers ask for
    const std::size_t count = std::min(kRecordsPerPacket, plan.pixels.size() - first);
    payload += data_packet(streams_of(plan, first, count));
    first += count;
  } while (first < plan.pixels.size());
  const std::uint64_t first_packet = e57_physical(start + kSectionHeaderLength);
  const std::uint64_t index = e57_physical(payload.size());
  payload += index_packet(first_packet);
  std::string header{1, 0, 0, 0, 0, 0, 0, 0};
  append_little_endian(header, static_cast<std::uint64_t>(payload.size() - start));
  append_little_endian(header, first_packet);
  append_little_endian(header, index);
  payload.replace(start, kSectionHeaderLength, header);
}

}  // namespace relief
