#include "tests/scan/io/e57/e57_builder.h"

#include "scan/io/e57/e57_pages.h"
#include "scan/io/files/binary_writer.h"

namespace relief::testing {

std::string doubles(const std::vector<double>& values) {
  std::string bytes;
  for (const double value : values) append_little_endian(bytes, value);
  return bytes;
}

std::string floats(const std::vector<float>& values) {
  std::string bytes;
  for (const float value : values) append_little_endian(bytes, value);
  return bytes;
}

std::string bits(const std::vector<std::uint64_t>& values, int bits) {
  std::string bytes;
  std::size_t at = 0;
  for (const std::uint64_t value : values) {
    for (int bit = 0; bit < bits; ++bit, ++at) {
      if (at % 8 == 0) bytes += '\0';
      if (value >> bit & 1u) bytes.back() = static_cast<char>(bytes.back() | 1 << at % 8);
    }
  }
  return bytes;
}

std::string data_packet(const std::vector<std::string>& streams) {
  std::string packet(4, '\0');
  packet[0] = 1;
  append_little_endian(packet, static_cast<std::uint16_t>(streams.size()));
  for (const auto& stream : streams)
    append_little_endian(packet, static_cast<std::uint16_t>(stream.size()));
  for (const auto& stream : streams) packet += stream;
  while (packet.size() % 4 != 0) packet += '\0';
  packet[2] = static_cast<char>((packet.size() - 1) & 255);
  packet[3] = static_cast<char>((packet.size() - 1) >> 8);
  return packet;
}

std::string index_packet() {
  std::string packet(32, '\0');
  packet[2] = 31;
  packet[4] = 1;
  return packet;
}

std::string empty_packet() {
  std::string packet(12, '\x55');
  packet[0] = 2;
  packet[1] = 0;
  packet[2] = 11;
  packet[3] = 0;
  return packet;
}

std::uint64_t E57Builder::add_section(const std::vector<std::string>& packets) {
  const std::size_t start = payload_.size();
  std::string body;
  for (const auto& packet : packets) body += packet;
  std::string header(8, '\0');
  header[0] = 1;
  append_little_endian(header, static_cast<std::uint64_t>(32 + body.size()));
  append_little_endian(header, e57_physical(start + 32));
  append_little_endian(header, std::uint64_t{0});
  payload_ += header + body;
  return e57_physical(start);
}

void E57Builder::add_scan(const std::string& prototype, std::uint64_t count,
                          const std::vector<std::string>& streams, const std::string& extra) {
  add_scan_of_packets(prototype, count, {data_packet(streams)}, extra);
}

void E57Builder::add_scan_of_packets(const std::string& prototype, std::uint64_t count,
                                     const std::vector<std::string>& packets,
                                     const std::string& extra) {
  const std::uint64_t offset = add_section(packets);
  add_scan_xml("<vectorChild type=\"Structure\">" + extra +
               "<points type=\"CompressedVector\" fileOffset=\"" + std::to_string(offset) +
               "\" recordCount=\"" + std::to_string(count) + "\"><prototype type=\"Structure\">" +
               prototype + "</prototype><codecs type=\"Vector\"/></points></vectorChild>");
}

std::string E57Builder::finish(const std::string& attributes) const {
  return finish_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?><e57Root type=\"Structure\" " +
                     attributes + "><data3D type=\"Vector\">" + scans_ + "</data3D></e57Root>");
}

std::string E57Builder::finish_with(const std::string& xml) const {
  const std::string payload = payload_ + xml;
  const std::uint64_t pages = (payload.size() + kE57PayloadBytes - 1) / kE57PayloadBytes;
  std::string header = "ASTM-E57";
  append_little_endian(header, std::uint32_t{1});
  append_little_endian(header, std::uint32_t{0});
  append_little_endian(header, pages * kE57PageBytes);
  append_little_endian(header, e57_physical(payload_.size()));
  append_little_endian(header, static_cast<std::uint64_t>(xml.size()));
  append_little_endian(header, kE57PageBytes);
  return e57_pages_from(header + payload.substr(header.size()));
}

std::string with_checksums(const std::string& content) {
  std::string payload;
  for (std::size_t at = 0; at < content.size(); at += kE57PageBytes)
    payload += content.substr(at, kE57PayloadBytes);
  return e57_pages_from(payload);
}

}  // namespace relief::testing
