// How the values of points are stored: pages, packets, bit widths and types.
#include "scan/io/e57/e57_records.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/e57/e57_layout.h"
#include "scan/io/e57/e57_pages.h"
#include "tests/scan/io/e57/e57_builder.h"
#include "tests/support/result_matchers.h"

namespace relief {
namespace {

using testing::bits;
using testing::data_packet;
using testing::E57Builder;
using ::testing::ElementsAre;

// The values of a field of scan 0, or the error.
Result<std::vector<double>> values_of(const std::string& content, const std::string& field) {
  auto pages = E57Pages::in_memory(content, "a.e57");
  if (!pages) return pages.error();
  const auto scans = read_e57_layout(*pages);
  if (!scans) return scans.error();
  std::vector<double> values;
  const auto read = read_e57_records(*pages, scans->front(),
                                     {{field, [&](std::size_t first, std::span<const double> some) {
                                         EXPECT_EQ(first, values.size());
                                         values.insert(values.end(), some.begin(), some.end());
                                       }}});
  if (!read) return read.error();
  return values;
}

std::string integer_field(const std::string& name, std::int64_t minimum, std::int64_t maximum) {
  return "<" + name + " type=\"Integer\" minimum=\"" + std::to_string(minimum) + "\" maximum=\"" +
         std::to_string(maximum) + "\"/>";
}

TEST(E57Pages, ChecksumIsThatOfTheStandard) {
  EXPECT_EQ(crc32c("123456789"), 0xe3069283u);
  EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8a9136aau);  // RFC 3720, B.4
  EXPECT_EQ(crc32c(""), 0u);
}

TEST(E57Pages, NamesThePageOfAWrongChecksum) {
  E57Builder builder;
  builder.add_scan("<a type=\"Float\"/>", 500, {testing::doubles(std::vector<double>(500, 2.0))});
  std::string content = builder.finish();
  ASSERT_EQ(values_of(content, "a")->size(), 500u);
  content[2 * 1024 + 100] ^= 1;
  EXPECT_THAT(values_of(content, "a"), HasError("a.e57: damaged E57: the checksum of page 2 (from "
                                                "byte 2048) does not match its content"));
}

TEST(E57Pages, RefusesWhatIsNoE57) {
  E57Builder builder;
  builder.add_scan("<a type=\"Float\"/>", 1, {testing::doubles({1})});
  const std::string content = builder.finish();
  const auto changed = [&](std::size_t at, char value) {
    std::string other = content;
    other[at] = value;
    return values_of(testing::with_checksums(other), "a");
  };
  EXPECT_THAT(values_of("", "a"), HasError("it has 0 bytes"));
  EXPECT_THAT(values_of(content.substr(0, content.size() - 1), "a"), HasError("truncated"));
  EXPECT_THAT(values_of(content + std::string(1024, '\0'), "a"), HasError("byte 16 of its header"));
  EXPECT_THAT(changed(0, 'B'), HasError("not an E57 file"));
  EXPECT_THAT(changed(8, 2), HasError("version 2"));
  EXPECT_THAT(changed(41, 2), HasError("pages of 512 bytes"));
  EXPECT_THAT(changed(26, 1), HasError("the XML section would be at byte"));
  EXPECT_THAT(changed(36, 1), HasError("more than the file has left"));
}

// Every width, with the bits of a value in two packets and packets of other kinds between.
TEST(E57Records, IntegersOfEveryWidthRunOnOverPackets) {
  std::mt19937_64 random(5);
  for (int width = 0; width <= 64; ++width) {
    const std::uint64_t range = width == 0 ? 0 : ~std::uint64_t{0} >> (64 - width);
    const std::int64_t minimum = width == 64   ? std::numeric_limits<std::int64_t>::min()
                                 : width == 63 ? -(1ll << 62)
                                               : -77;
    const auto maximum = static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + range);
    std::vector<std::uint64_t> raw(6000);
    for (auto& value : raw) value = random() & range;
    std::string stream = bits(raw, width);
    std::string other = bits(std::vector<std::uint64_t>(6000, 5), 3);
    std::vector<std::string> packets;
    while (!stream.empty() || !other.empty()) {
      const auto take = [&](std::string& from) {
        const std::string head = from.substr(0, random() % 5000);
        from.erase(0, head.size());
        return head;
      };
      const std::string first = take(stream);
      packets.push_back(data_packet({first, take(other)}));
      packets.push_back(random() % 2 ? testing::index_packet() : testing::empty_packet());
    }
    E57Builder builder;
    builder.add_scan_of_packets(integer_field("a", minimum, maximum) + integer_field("b", 0, 7),
                                raw.size(), packets);
    const auto values = values_of(builder.finish(), "a");
    ASSERT_THAT(values, IsOk()) << width;
    ASSERT_EQ(values->size(), raw.size());
    for (std::size_t i = 0; i < raw.size(); ++i)
      ASSERT_EQ((*values)[i], static_cast<double>(static_cast<std::int64_t>(
                                  raw[i] + static_cast<std::uint64_t>(minimum))))
          << width << " bits, record " << i;
    EXPECT_EQ(*values_of(builder.finish(), "b"), std::vector<double>(raw.size(), 5.0)) << width;
  }
}

TEST(E57Records, ReadsEveryType) {
  const std::string prototype =
      "<a type=\"Float\" precision=\"single\"/><b type=\"Float\"/>"
      "<c type=\"ScaledInteger\" minimum=\"-10\" maximum=\"21\" scale=\"0.001\" offset=\"7\"/>"
      "<text type=\"String\"/><d type=\"Integer\"/>";
  E57Builder builder;
  builder.add_scan(prototype, 2,
                   {testing::floats({0.1f, -2.5f}), testing::doubles({0.1, 1e300}),
                    bits({0, 31}, 5), std::string("\x04hi\x02?", 5), bits({0, ~0ull}, 64)});
  const std::string content = builder.finish();
  EXPECT_THAT(*values_of(content, "a"), ElementsAre(static_cast<double>(0.1f), -2.5));
  EXPECT_THAT(*values_of(content, "b"), ElementsAre(0.1, 1e300));
  EXPECT_THAT(*values_of(content, "c"), ElementsAre(-10 * 0.001 + 7, 21 * 0.001 + 7));
  EXPECT_THAT(*values_of(content, "d"), ElementsAre(-0x1p63, 0x1p63));
  EXPECT_THAT(*values_of(content, "text"), ElementsAre());
}

TEST(E57Records, NamesTheByteOfADamagedPacket) {
  const auto read = [](const std::string& packet, std::uint64_t count = 1) {
    E57Builder builder;
    builder.add_scan_of_packets("<a type=\"Float\"/>", count, {packet});
    return values_of(builder.finish(), "a");
  };
  const std::string sound = data_packet({testing::doubles({1})});
  ASSERT_THAT(read(sound), IsOk());
  const auto changed = [&](std::size_t at, char value) {
    std::string packet = sound;
    packet[at] = value;
    return read(packet);
  };
  EXPECT_THAT(changed(0, 9), HasError("byte 80 (page 0): a packet of the unknown type 9"));
  EXPECT_THAT(changed(2, 99), HasError("byte 80 (page 0): a packet of 100 bytes"));
  EXPECT_THAT(changed(2, 16), HasError("a packet of 17 bytes"));
  EXPECT_THAT(changed(4, 2), HasError("2 bytestreams for points of 1 fields"));
  EXPECT_THAT(changed(6, 100), HasError("the bytestream of a has 100 bytes"));
  EXPECT_THAT(read(sound, 2), HasError("the packets end after 1 of 2 values of a"));
  EXPECT_THAT(read(""), HasError("after 0 of 1 values"));
}

TEST(E57Records, NamesTheByteOfADamagedSection) {
  E57Builder builder;
  builder.add_scan("<a type=\"Float\"/>", 1, {testing::doubles({1})});
  const auto changed = [&](std::size_t at, char value) {
    std::string content = builder.finish();
    content[at] = value;
    return values_of(testing::with_checksums(content), "a");
  };
  EXPECT_THAT(changed(48, 7), HasError("byte 48 (page 0): a section of points begins with 1"));
  EXPECT_THAT(changed(59, 1), HasError("has a length of 16777264 bytes"));
  EXPECT_THAT(changed(67, 1), HasError("the first packet of the points would be at byte"));
}

TEST(E57Layout, NamesWhatIsWrongInTheXml) {
  const auto read = [](const std::string& prototype) {
    E57Builder builder;
    builder.add_scan(prototype, 1, {testing::doubles({1})});
    return values_of(builder.finish(), "a");
  };
  EXPECT_THAT(read("<a type=\"Blob\"/>"), HasError("scan 0 of the E57: the field a has the "
                                                   "unknown type 'Blob'"));
  EXPECT_THAT(read("<a type=\"Float\" precision=\"half\"/>"), HasError("'half'"));
  EXPECT_THAT(read("<a type=\"Integer\" minimum=\"x\"/>"), HasError("the minimum 'x'"));
  EXPECT_THAT(read("<a type=\"Integer\" minimum=\"3\" maximum=\"2\"/>"),
              HasError("a minimum above its maximum"));
  EXPECT_THAT(read("<a type=\"ScaledInteger\" scale=\"inf\"/>"), HasError("the scale 'inf'"));
  std::string nested = "<a type=\"Float\"/>";
  for (int i = 0; i < 20; ++i) nested = "<s type=\"Structure\">" + nested + "</s>";
  EXPECT_THAT(read(nested), HasError("nested too deeply"));
  EXPECT_THAT(values_of(E57Builder().finish_with("<e57Root><data3D>"), "a"),
              HasError("its XML section breaks off at its byte"));
  EXPECT_THAT(values_of(E57Builder().finish_with("<other/>"), "a"), HasError("no e57Root"));
}

TEST(E57Layout, DeepXmlIsNoTrouble) {
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "<a>";
  EXPECT_THAT(values_of(E57Builder().finish_with(deep), "a"), HasError("breaks off"));
  for (int i = 0; i < 200000; ++i) deep += "</a>";
  EXPECT_THAT(values_of(E57Builder().finish_with(deep), "a"), HasError("no e57Root"));
}

TEST(E57Layout, KnowsTheCodecOfTheStandardOnly) {
  const auto read = [](const std::string& codec) {
    E57Builder builder;
    const std::uint64_t offset = builder.add_section({data_packet({testing::doubles({1})})});
    builder.add_scan_xml("<vectorChild><points fileOffset=\"" + std::to_string(offset) +
                         "\" recordCount=\"1\"><prototype><a type=\"Float\"/></prototype><codecs>"
                         "<vectorChild><inputs/><" +
                         codec + "/></vectorChild></codecs></points></vectorChild>");
    return values_of(builder.finish(), "a");
  };
  EXPECT_THAT(read("bitPackCodec"), IsOk());
  EXPECT_THAT(read("zipCodec"), HasError("scan 0 of the E57: its points are packed by an unknown"));
}

}  // namespace
}  // namespace relief
