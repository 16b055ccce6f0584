#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

constexpr std::size_t page = 1024, content = 1020;

std::uint64_t physical(std::uint64_t logical) { return logical / content * page + logical % content; }

// The stored form: pages with checksums.
Bytes paged(Bytes logical) {
  logical.resize((logical.size() + content - 1) / content * content);
  Bytes stored;
  for (std::size_t at = 0; at < logical.size(); at += content) {
    boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
    crc.process_bytes(logical.data() + at, content);
    stored.insert(stored.end(), logical.begin() + static_cast<std::ptrdiff_t>(at),
                  logical.begin() + static_cast<std::ptrdiff_t>(at + content));
    push(stored, static_cast<std::uint32_t>(crc.checksum()), true);
  }
  return stored;
}

// A stream of bits, the lowest first.
class Bits {
 public:
  void add(std::uint64_t value, unsigned width) {
    for (unsigned i = 0; i < width; ++i, ++count_) {
      if (count_ % 8 == 0) bytes_.push_back(std::byte{0});
      if ((value >> i & 1) != 0) bytes_.back() |= static_cast<std::byte>(1U << count_ % 8);
    }
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value), 64); }
  void add(float value) { add(std::bit_cast<std::uint32_t>(value), 32); }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
  std::size_t count_ = 0;
};

struct MadeScan {
  std::string prototype;  // the elements of the fields
  std::vector<Bits> fields;
  std::uint64_t records = 0;
  std::string pose;
};

// An E57 file. Packets hold `packet_bytes` of each field, with an index packet between them.
Bytes e57(const std::vector<MadeScan>& scans, std::size_t packet_bytes = 100, const std::string& metadata = "") {
  Bytes logical(48);
  std::string list;
  for (const auto& scan : scans) {
    const std::size_t section = logical.size();
    logical.resize(section + 32);
    for (std::size_t from = 0; true; from += packet_bytes) {
      Bytes packet(6 + 2 * scan.fields.size());
      bool any = false;
      for (std::size_t f = 0; f < scan.fields.size(); ++f) {
        const Bytes& all = scan.fields[f].bytes();
        const std::size_t n = from < all.size() ? std::min(packet_bytes, all.size() - from) : 0;
        any = any || n > 0;
        put(packet, 6 + 2 * f, static_cast<std::uint16_t>(n));
        if (n > 0)
          packet.insert(packet.end(), all.begin() + static_cast<std::ptrdiff_t>(from),
                        all.begin() + static_cast<std::ptrdiff_t>(from + n));
      }
      if (!any) break;
      packet.resize((packet.size() + 3) / 4 * 4);
      packet[0] = std::byte{1};
      put(packet, 2, static_cast<std::uint16_t>(packet.size() - 1));
      put(packet, 4, static_cast<std::uint16_t>(scan.fields.size()));
      logical.insert(logical.end(), packet.begin(), packet.end());
      Bytes index(16);
      put(index, 2, std::uint16_t{15});
      logical.insert(logical.end(), index.begin(), index.end());
    }
    logical[section] = std::byte{1};
    put(logical, section + 8, static_cast<std::uint64_t>(logical.size() - section));
    put(logical, section + 16, physical(section + 32));
    list += "<vectorChild type=\"Structure\">" + scan.pose + "<points type=\"CompressedVector\" fileOffset=\"" +
            std::to_string(physical(section)) + "\" recordCount=\"" + std::to_string(scan.records) +
            "\"><prototype type=\"Structure\">" + scan.prototype + "</prototype></points></vectorChild>";
  }
  const std::string xml =
      "<?xml version=\"1.0\"?>\n<e57Root type=\"Structure\"><coordinateMetadata type=\"String\"><![CDATA[" + metadata +
      "]]></coordinateMetadata><data3D type=\"Vector\">" + list + "</data3D></e57Root>\n";
  const std::size_t xml_at = logical.size();
  const Bytes text = bytes_of(xml);
  logical.insert(logical.end(), text.begin(), text.end());
  std::memcpy(logical.data(), "ASTM-E57", 8);
  put(logical, 8, std::uint32_t{1});
  put(logical, 16, static_cast<std::uint64_t>((logical.size() + content - 1) / content * page));
  put(logical, 24, physical(xml_at));
  put(logical, 32, static_cast<std::uint64_t>(xml.size()));
  put(logical, 40, static_cast<std::uint64_t>(page));
  return paged(std::move(logical));
}

std::string element(const std::string& name, const std::string& attributes) {
  return "<" + name + " type=" + attributes + "/>";
}

const std::string doubles =
    element("cartesianX", "\"Float\"") + element("cartesianY", "\"Float\"") + element("cartesianZ", "\"Float\"");

MadeScan scan_of(const std::vector<Point>& points) {
  MadeScan scan{.prototype = doubles, .fields = std::vector<Bits>(3), .records = points.size(), .pose = ""};
  for (const Point& p : points)
    for (int axis = 0; axis < 3; ++axis) scan.fields[static_cast<std::size_t>(axis)].add(p[axis]);
  return scan;
}

std::string refusal(const Bytes& bytes) { return sentence(read_bytes(bytes, "a.e57")); }

TEST(E57Reader, ReadsNumbersOfAllKindsOverPacketsAndPages) {
  MadeScan scan;
  scan.prototype =
      element("cartesianX", "\"Float\" precision=\"single\"") +
      element("cartesianY", "\"ScaledInteger\" minimum=\"-1000\" maximum=\"3000\" scale=\"0.25\" offset=\"7\"") +
      element("cartesianZ", "\"Integer\" minimum=\"5\" maximum=\"5\"") +
      element("intensity", "\"ScaledInteger\" minimum=\"0\" maximum=\"4095\" scale=\"0.5\"") +
      element("colorRed", "\"Integer\" minimum=\"0\" maximum=\"255\"") + element("nor:big", "\"Integer\"");
  scan.fields.resize(6);
  scan.records = 3000;
  for (std::uint64_t i = 0; i < scan.records; ++i) {
    scan.fields[0].add(static_cast<float>(i) / 8);
    scan.fields[1].add(i, 12);
    scan.fields[3].add(i % 4096, 12);
    scan.fields[4].add(i % 256, 8);
    scan.fields[5].add((std::uint64_t{1} << 63) + i * 9'007'199'254'740'993, 64);
  }
  for (const std::size_t packet_bytes : {7, 100, 4000}) {
    const Bytes bytes = e57({scan}, packet_bytes);
    const std::vector<Attribute> schema{{"intensity", AttributeType::f64},
                                        {"red", AttributeType::u8},
                                        {"nor:big", AttributeType::i64},
                                        {"scan", AttributeType::u32}};
    const auto read = read_bytes(bytes, "a.e57", schema);
    ASSERT_EQ(sentence(read), "");
    EXPECT_EQ(read.value().info.attributes, schema);
    EXPECT_EQ(read.value().info.points, 3000u);
    ASSERT_EQ(read.value().points.size(), 3000u);
    for (std::size_t i = 0; i < 3000; ++i) {
      const auto n = static_cast<double>(i);
      EXPECT_EQ(read.value().points[i], (Point{n / 8, (n - 1000) * 0.25 + 7, 5}));
      EXPECT_EQ(cell<double>(read.value(), schema, i, 0), n / 2);
      EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, i, 1), i % 256);
      EXPECT_EQ(cell<std::int64_t>(read.value(), schema, i, 2), static_cast<std::int64_t>(i * 9'007'199'254'740'993));
    }
  }
}

TEST(E57Reader, MovesEachScanByItsPose) {
  const std::vector<Point> points{{1, 2, 3}, {-4, 5, 0.5}};
  MadeScan moved = scan_of(points), turned = scan_of(points);
  moved.pose =
      "<pose type=\"Structure\"><translation type=\"Structure\"><x type=\"Float\">10</x><y type=\"Float\"/>"
      "<z type=\"Float\">-2.5e-01</z></translation></pose>";
  turned.pose =
      "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">0</w><x type=\"Float\">0</x>"
      "<y type=\"Float\">0</y><z type=\"Float\">1</z></rotation></pose>";
  const std::vector<Attribute> schema{{"scan", AttributeType::u32}};
  const auto read = read_bytes(e57({scan_of(points), scan_of({}), moved, turned}), "a.e57", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points,
            (std::vector<Point>{{1, 2, 3}, {-4, 5, 0.5}, {11, 2, 2.75}, {6, 5, 0.25}, {-1, -2, 3}, {4, -5, 0.5}}));
  EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 1, 0), 0u);
  EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 2, 0), 2u);
  EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 5, 0), 3u);
}

TEST(E57Reader, SaysWhereTheScannerWasIfTheFileSaysSo) {
  MadeScan moved = scan_of({{1, 2, 3}});
  moved.pose =
      "<pose type=\"Structure\"><translation type=\"Structure\"><x type=\"Float\">10</x><y type=\"Float\">-4</y>"
      "<z type=\"Float\"/></translation></pose>";
  const std::vector<Attribute> schema{{"scan", AttributeType::u32},
                                      {"x_origin", AttributeType::f64},
                                      {"y_origin", AttributeType::f64},
                                      {"z_origin", AttributeType::f64}};
  const auto read = read_bytes(e57({scan_of({{1, 2, 3}}), moved}), "a.e57", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.attributes, schema);
  EXPECT_TRUE(std::isnan(cell<double>(read.value(), schema, 0, 1)));
  EXPECT_EQ(cell<double>(read.value(), schema, 1, 1), 10);
  EXPECT_EQ(cell<double>(read.value(), schema, 1, 2), -4);
  EXPECT_EQ(cell<double>(read.value(), schema, 1, 3), 0);
  EXPECT_EQ(read_bytes(e57({scan_of({{1, 2, 3}})}), "a.e57").value().info.attributes.size(), 1u);
}

TEST(E57Reader, OtherScansThanThoseAskedForArePassedOverAndCounted) {
  MadeScan marked = scan_of({{7, 7, 7}, {8, 8, 8}});  // may have records that are no points, so it is read
  marked.prototype += element("cartesianInvalidState", "\"Integer\" minimum=\"0\" maximum=\"2\"");
  marked.fields.emplace_back();
  marked.fields[3].add(0, 2);
  marked.fields[3].add(1, 2);
  const auto bytes = e57({scan_of({{1, 1, 1}, {2, 2, 2}}), marked, scan_of({{3, 3, 3}}), scan_of({{4, 4, 4}})});
  const auto reader = open_bytes(bytes, "a.e57", {}, ReadHints{.scans = {2}});
  ASSERT_EQ(sentence(reader), "");
  PointBatch batch;
  std::vector<Point> points;
  std::vector<std::uint64_t> passed_over;
  do {
    ASSERT_EQ(sentence(reader.value()->next(batch)), "");
    points.insert(points.end(), batch.points.begin(), batch.points.end());
    passed_over.push_back(batch.passed_over);
  } while (!batch.points.empty());
  EXPECT_EQ(points, (std::vector<Point>{{7, 7, 7}, {3, 3, 3}}));
  EXPECT_EQ(passed_over, (std::vector<std::uint64_t>{2, 0, 1}));
}

TEST(E57Reader, InvalidPointsAreLeftOutAndSphericalOnesConverted) {
  MadeScan scan;
  scan.prototype = element("sphericalRange", "\"Float\"") + element("sphericalAzimuth", "\"Float\"") +
                   element("sphericalElevation", "\"Float\"") +
                   element("sphericalInvalidState", "\"Integer\" minimum=\"0\" maximum=\"2\"");
  scan.fields.resize(4);
  scan.records = 3;
  for (const double range : {2.0, 3.0, 4.0}) {
    scan.fields[0].add(range);
    scan.fields[1].add(std::numbers::pi / 2);
    scan.fields[2].add(range == 4 ? -std::numbers::pi / 2 : 0.0);
    scan.fields[3].add(range == 3 ? 1 : 0, 2);
  }
  const auto read = read_bytes(e57({scan}), "a.e57");
  ASSERT_EQ(sentence(read), "");
  EXPECT_FALSE(read.value().info.points);
  ASSERT_EQ(read.value().points.size(), 2u);
  EXPECT_NEAR(read.value().points[0].y, 2, 1e-15);
  EXPECT_NEAR(read.value().points[1].z, -4, 1e-15);
}

TEST(E57Reader, TheCoordinateSystemIsKept) {
  EXPECT_EQ(read_bytes(e57({scan_of({{1, 2, 3}})}, 100, "EPSG:2154"), "a.e57").value().info.crs, "EPSG:2154");
}

TEST(E57Reader, ReadsWhatOtherProgramsWrite) {
  const std::string folder = TESSERA_TEST_DATA "/scans/";
  const auto cloud_compare = read_path(folder + "testWithNormals.e57");
  ASSERT_EQ(sentence(cloud_compare), "");
  EXPECT_EQ(cloud_compare.value().points, (std::vector<Point>{{1, 0, 0}, {2, 0, 0}}));
  ASSERT_EQ(cloud_compare.value().info.attributes.size(), 4u);
  EXPECT_EQ(cloud_compare.value().info.attributes[0].name, "nor:normalX");
  const auto pye57 = read_path(folder + "translationWithoutRotation.e57");
  ASSERT_EQ(sentence(pye57), "");
  EXPECT_EQ(pye57.value().points, (std::vector<Point>{{4, 5, 6}, {5, 5, 6}, {4, 6, 6}, {5, 6, 6}}));
}

TEST(E57Reader, AnyDamagedByteOfAPageIsFound) {
  const Bytes whole = e57({scan_of(std::vector<Point>(200, {1, 2, 3}))});
  ASSERT_EQ(refusal(whole), "");
  for (std::size_t at = 0; at < whole.size(); at += 97) {
    Bytes bytes = whole;
    bytes[at] ^= std::byte{0x10};
    EXPECT_NE(refusal(bytes), "") << at;
  }
  Bytes bytes = whole;
  bytes.resize(bytes.size() - page);
  EXPECT_NE(refusal(bytes).find("but its header promises"), std::string::npos);
  bytes.resize(20);
  EXPECT_EQ(refusal(bytes), "a.e57: ends within the header of an E57 file");
}

TEST(E57Reader, WhatMakesNoSenseIsRefused) {
  MadeScan scan = scan_of({{1, 2, 3}});
  scan.records = 2;
  EXPECT_NE(refusal(e57({scan})).find("their packets end while field 'cartesianX' is read"), std::string::npos);
  scan.records = std::uint64_t{1} << 60;
  EXPECT_NE(refusal(e57({scan})).find("more than the file can hold"), std::string::npos);
  scan = scan_of({{1, 2, 3}});
  scan.prototype = element("cartesianX", "\"Float\"") + element("cartesianY", "\"Float\"") + element("z", "\"Float\"");
  EXPECT_EQ(refusal(e57({scan})), "a.e57: scan 0 has neither cartesian nor spherical coordinates in 3D");
  scan.prototype = element("cartesianX", "\"Blob\"");
  EXPECT_EQ(refusal(e57({scan})), "a.e57: in its XML section, field 'cartesianX' has the unknown type 'Blob'");
  scan.prototype = element("cartesianX", "\"Integer\" minimum=\"5\" maximum=\"4\"");
  EXPECT_EQ(refusal(e57({scan})), "a.e57: in its XML section, field 'cartesianX' has no valid maximum");
  scan.prototype = "<cartesianX type=\"Float\">";
  EXPECT_NE(refusal(e57({scan})).find("is not well formed"), std::string::npos);
  scan = scan_of({{1, 2, 3}});
  scan.pose = "<pose><rotation><w>2</w></rotation></pose>";
  EXPECT_EQ(refusal(e57({scan})), "a.e57: scan 0 has a pose whose rotation is not a unit quaternion");
  EXPECT_EQ(refusal(e57({})), "a.e57: holds no points");
  scan = scan_of({{1, 2, 3}});
  scan.fields.resize(2);
  EXPECT_NE(refusal(e57({scan})).find("a packet has 2 streams, but a record has 3 fields"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing_io
