#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "tests/input/las_file.h"

namespace tessera::testing_io {
namespace {

LasFile small_file(int minor, std::uint8_t format, std::uint16_t extra_bytes) {
  LasFile file;
  file.minor = minor;
  file.format = format;
  file.extra_bytes = extra_bytes;
  file.offset = {1000, -2000.5, 0};
  file.points = {{100, 200, 300}, {-1, 0, 1}, {INT32_MAX, INT32_MIN, 7}};
  return file;
}

class EveryFormat : public testing::TestWithParam<int> {};

TEST_P(EveryFormat, GivesItsCoordinatesWhateverTheRecordLength) {
  for (const int extra : {0, 1, 17}) {
    const auto file =
        small_file(GetParam() < 4 ? 2 : 4, static_cast<std::uint8_t>(GetParam()), static_cast<std::uint16_t>(extra));
    const auto read = read_bytes(file.bytes(), "a.las");
    ASSERT_EQ(sentence(read), "");
    const std::vector<Point> expected{
        {1001, -1998.5, 3}, {999.99, -2000.5, 0.01}, {21475836.47 + 1000, -21474836.48 - 2000.5, 0.07}};
    ASSERT_EQ(read.value().points.size(), 3u);
    EXPECT_EQ(read.value().points[0], expected[0]);
    EXPECT_EQ(read.value().points[1], expected[1]);
    EXPECT_EQ(read.value().points[2].x, 21475836.47);
    EXPECT_EQ(read.value().points[2].y, -21476836.98);
    EXPECT_EQ(read.value().info.points, 3u);
  }
}

// Byte k of record i is i + k, so every field says where it stood.
TEST_P(EveryFormat, GivesTheAttributesOfItsFormat) {
  const int format = GetParam();
  const auto file = small_file(4, static_cast<std::uint8_t>(format), 0);
  auto reader = open_bytes(file.bytes(), "a.las");
  ASSERT_EQ(sentence(reader), "");
  std::vector<Attribute> schema;
  for (const auto& a : reader.value()->info().attributes) schema.push_back({a.name, AttributeType::f64});
  const auto read = read_bytes(file.bytes(), "a.las", schema);
  ASSERT_EQ(sentence(read), "");
  std::map<std::string, double> found;
  for (std::size_t c = 0; c < schema.size(); ++c) found[schema[c].name] = cell<double>(read.value(), schema, 1, c);

  const bool wide = format >= 6;
  const auto u16_at = [](int at) { return (at + 1) | (at + 2) << 8; };  // in record 1
  std::map<std::string, double> expected{{"intensity", u16_at(12)},
                                         {"return_number", wide ? 15 & 15 : 15 & 7},
                                         {"number_of_returns", wide ? 15 >> 4 : 15 >> 3 & 7},
                                         {"classification", wide ? 17 : 16 & 31},
                                         {"scan_angle", wide ? u16_at(18) * 0.006 : 17},
                                         {"user_data", 18},
                                         {"point_source_id", u16_at(wide ? 20 : 18)},
                                         {"synthetic", wide ? 16 & 1 : 16 >> 5 & 1},
                                         {"key_point", wide ? 16 >> 1 & 1 : 16 >> 6 & 1},
                                         {"withheld", wide ? 16 >> 2 & 1 : 16 >> 7 & 1}};
  if (wide) expected["overlap"] = 16 >> 3 & 1;
  if (format != 0 && format != 2) {
    const std::size_t at = file.points_at() + file.record_bytes() + (wide ? 22 : 20);
    std::memcpy(&expected["gps_time"], file.bytes().data() + at, sizeof(double));
  }
  const std::map<int, int> colour_at{{2, 20}, {3, 28}, {5, 28}, {7, 30}, {8, 30}, {10, 30}};
  if (colour_at.count(format) > 0) {
    const int at = colour_at.at(format);
    expected.insert({{"red", u16_at(at)}, {"green", u16_at(at + 2)}, {"blue", u16_at(at + 4)}});
  }
  if (format == 8 || format == 10) expected["nir"] = u16_at(36);
  EXPECT_EQ(found, expected);
}

INSTANTIATE_TEST_SUITE_P(LasReader, EveryFormat, testing::Range(0, 11));

TEST(LasReader, NamesExtraBytesByTheirDescriptors) {
  auto file = small_file(4, 6, 15);
  Bytes descriptors(192 * 4);
  const auto describe = [&](std::size_t i, std::uint8_t type, std::uint8_t options, const char* name) {
    put(descriptors, 192 * i + 2, type);
    put(descriptors, 192 * i + 3, options);
    std::memcpy(descriptors.data() + 192 * i + 4, name, std::strlen(name));
  };
  describe(0, 3, 0, "height/cm");  // u16; '/' would be a folder in HDF5
  describe(1, 0, 3, "opaque");     // 3 undocumented bytes
  describe(2, 4, 0x18, "scaled");  // i16, scaled
  put(descriptors, 192 * 2 + 112, 0.5);
  put(descriptors, 192 * 2 + 136, -100.0);
  describe(3, 10, 0, "intensity");  // f64, a name already taken
  file.records.push_back({"LASF_Spec", 4, descriptors});
  auto reader = open_bytes(file.bytes(), "a.las");
  ASSERT_EQ(sentence(reader), "");
  const auto schema = reader.value()->info().attributes;
  ASSERT_EQ(schema.size(), 12u + 3);
  EXPECT_EQ(schema[12], (Attribute{"height_cm", AttributeType::u16}));
  EXPECT_EQ(schema[13], (Attribute{"scaled", AttributeType::f64}));
  EXPECT_EQ(schema[14], (Attribute{"intensity_2", AttributeType::f64}));
  const auto read = read_bytes(file.bytes(), "a.las", schema);
  EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 0, 12), 30 | 31 << 8);
  EXPECT_EQ(cell<double>(read.value(), schema, 0, 13), (35 | 36 << 8) * 0.5 - 100);
}

TEST(LasReader, ASecondRecordOfExtraBytesGoesOnWhereTheFirstOneEnds) {
  auto file = small_file(4, 6, 3);
  for (const char* name : {"first", "second"}) {
    Bytes descriptor(192);
    descriptor[2] = std::byte{name[0] == 'f' ? std::uint8_t{1} : std::uint8_t{3}};  // a byte, then a u16
    std::memcpy(descriptor.data() + 4, name, std::strlen(name));
    file.extended.push_back({"LASF_Spec", 4, descriptor});
  }
  const auto read = read_bytes(file.bytes(), "a.las", {{"first", AttributeType::u8}, {"second", AttributeType::u16}});
  ASSERT_EQ(sentence(read), "");
  const std::vector<Attribute> schema{{"first", AttributeType::u8}, {"second", AttributeType::u16}};
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 0), 30);
  EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 0, 1), 31 | 32 << 8);
}

TEST(LasReader, ReadsTheFlagsOfAPoint) {
  const std::vector<Attribute> schema{{"synthetic", AttributeType::u8},
                                      {"key_point", AttributeType::u8},
                                      {"withheld", AttributeType::u8},
                                      {"overlap", AttributeType::u8}};
  LasFile old;
  for (int i = 0; i < 256; ++i) old.points.push_back({i, 0, 0});  // byte 15 of record i is i + 15
  const auto read = read_bytes(old.bytes(), "a.las", schema).value();
  LasFile wide = old;
  wide.minor = 4;
  wide.format = 6;
  const auto wide_read = read_bytes(wide.bytes(), "a.las", schema).value();
  for (std::size_t i = 0; i < 256; ++i) {
    const auto flags = static_cast<std::uint8_t>(i + 15);
    for (unsigned k = 0; k < 3; ++k) EXPECT_EQ(cell<std::uint8_t>(read, schema, i, k), flags >> (5 + k) & 1) << i;
    EXPECT_EQ(cell<std::uint8_t>(read, schema, i, 3), 0) << "point formats below 6 have no such flag";
    for (unsigned k = 0; k < 4; ++k) EXPECT_EQ(cell<std::uint8_t>(wide_read, schema, i, k), flags >> k & 1) << i;
  }
}

TEST(LasReader, ConvertsAttributesToTheTypesAskedForAndFillsLackingOnesWithZero) {
  const std::vector<Attribute> schema{
      {"intensity", AttributeType::u8}, {"nir", AttributeType::u16}, {"user_data", AttributeType::f64}};
  const auto read = read_bytes(small_file(2, 0, 0).bytes(), "a.las", schema);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 0), 255) << "12 + 13 * 256 is too large for a byte";
  EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 0, 1), 0);
  EXPECT_EQ(cell<double>(read.value(), schema, 0, 2), 17.0);
}

TEST(LasReader, FindsTheCoordinateSystem) {
  const Bytes wkt = bytes_of(std::string("PROJCS[\"x\"]\0\0", 13));
  Bytes keys;
  for (const int v : {1, 1, 0, 3, 1024, 0, 1, 1, 2048, 0, 1, 4171, 3072, 0, 1, 2154})
    push(keys, static_cast<std::uint16_t>(v));
  auto file = small_file(4, 6, 0);
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "");
  file.records.push_back({"LASF_Projection", 34735, keys});
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "EPSG:2154");
  put<std::uint16_t>(file.records[0].payload, 8 + 16 + 6, 32767);  // user-defined, without parameters
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "") << "projected, so not longitude and latitude";
  EXPECT_NE(read_bytes(file.bytes(), "a.las").value().info.crs_note, "");
  file.extended.push_back({"LASF_Projection", 2112, wkt});
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "PROJCS[\"x\"]");
  file.extended[0].payload[3] = std::byte{0xFF};  // not UTF-8: the manifest could not be written
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "PRO?CS[\"x\"]");
}

// As some files have: two quotation marks where the text should be.
TEST(LasReader, TextThatIsNoSystemCountsAsNoneWithANote) {
  auto file = small_file(4, 6, 0);
  file.records.push_back({"LASF_Projection", 2112, bytes_of(std::string("''\0", 3))});
  const auto info = read_bytes(file.bytes(), "a.las").value().info;
  EXPECT_EQ(info.crs, "");
  EXPECT_EQ(info.crs_note, "its well-known text is not understood: '' is not a coordinate system");
  Bytes keys;
  for (const int v : {1, 1, 0, 3, 1024, 0, 1, 1, 2048, 0, 1, 4171, 3072, 0, 1, 2154})
    push(keys, static_cast<std::uint16_t>(v));
  file.records.push_back({"LASF_Projection", 34735, keys});
  EXPECT_EQ(read_bytes(file.bytes(), "a.las").value().info.crs, "EPSG:2154");
}

TEST(LasReader, TakesThe64BitCountOfLas14) {
  auto bytes = small_file(4, 6, 0).bytes();
  put<std::uint32_t>(bytes, 107, 3);
  EXPECT_EQ(read_bytes(bytes, "a.las").value().points.size(), 3u);
  put<std::uint32_t>(bytes, 107, 2);
  EXPECT_EQ(sentence(read_bytes(bytes, "a.las")), "a.las: the header gives two numbers of points, 2 and 3");
  put<std::uint64_t>(bytes, 247, 0);  // some writers fill the old one only
  EXPECT_EQ(read_bytes(bytes, "a.las").value().points.size(), 2u);
}

TEST(LasReader, ToleratesBytesAfterThePoints) {
  auto bytes = small_file(2, 1, 0).bytes();
  bytes.resize(bytes.size() + 1000);
  EXPECT_EQ(read_bytes(bytes, "a.las").value().points.size(), 3u);
}

TEST(LasReader, SeeksToAnyPoint) {
  LasFile file;
  for (int i = 0; i < 1000; ++i) file.points.push_back({i, -i, 7});
  auto reader = open_bytes(file.bytes(), "a.las");
  PointBatch batch;
  ASSERT_TRUE(reader.value()->seek(990).value());
  ASSERT_EQ(sentence(reader.value()->next(batch, 3)), "");
  ASSERT_EQ(batch.points.size(), 3u);
  EXPECT_EQ(batch.points[1].x, 9.91);
  EXPECT_EQ(reader.value()->place(1), "record 991");
  ASSERT_TRUE(reader.value()->seek(5000).value());
  ASSERT_EQ(sentence(reader.value()->next(batch, 3)), "");
  EXPECT_TRUE(batch.points.empty());
}

// Every prefix of a file with variable length records, of every version.
TEST(LasReader, RefusesEveryTruncationWithASentence) {
  for (int minor = 0; minor <= 4; ++minor) {
    auto file = small_file(minor, minor == 4 ? 6 : 0, 2);
    file.records.push_back({"LASF_Projection", 2112, bytes_of("PROJCS[]")});
    if (minor == 4) file.extended.push_back({"someone", 7, bytes_of("something")});
    const auto whole = file.bytes();
    ASSERT_EQ(sentence(read_bytes(whole, "a.las")), "");
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto read = read_bytes(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "a.las");
      ASSERT_TRUE(read.has_error()) << size;
      ASSERT_EQ(read.error().code, Errc::bad_input);
      ASSERT_EQ(read.error().where.substr(0, 5), "a.las");
    }
  }
}

TEST(LasReader, NamesTheRecordAtWhichAFileEnds) {
  auto bytes = small_file(2, 0, 0).bytes();
  bytes.resize(bytes.size() - 25);  // all of record 2 and the end of record 1
  EXPECT_EQ(sentence(read_bytes(bytes, "a.las")),
            "a.las, record 1: the file ends before or within this record, but its header promises 3 records");
}

struct Wrong {
  const char* what;
  std::size_t at;
  Bytes value;
  const char* part_of_sentence;
};

template <class T>
Bytes raw(T value) {
  Bytes bytes;
  push(bytes, value);
  return bytes;
}

TEST(LasReader, RefusesAbsurdHeaders) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::vector<Wrong> wrongs{
      {"magic", 0, bytes_of("LASX"), "does not begin with LASF"},
      {"major version", 24, raw<std::uint8_t>(2), "is LAS 2.4"},
      {"minor version", 25, raw<std::uint8_t>(5), "is LAS 1.5"},
      {"header size 0", 94, raw<std::uint16_t>(0), "claims 0 bytes"},
      {"header size of LAS 1.2", 94, raw<std::uint16_t>(227), "claims 227 bytes"},
      {"header size beyond the file", 94, raw<std::uint16_t>(65535), "ends within the LAS header"},
      {"points within the header", 96, raw<std::uint32_t>(100), "puts the points at byte 100"},
      {"points beyond the file", 96, raw<std::uint32_t>(0xFFFFFFFF), "puts the points at byte 4294967295"},
      {"4 billion records", 100, raw<std::uint32_t>(0xFFFFFFFF), "variable length record 0 of 4294967295"},
      {"LAZ without a LASzip record", 104, raw<std::uint8_t>(0x86), "has no LASzip record"},
      {"LAZ with waveforms", 104, raw<std::uint8_t>(0x89), "claim 30 bytes"},
      {"point format", 104, raw<std::uint8_t>(11), "point format 11 is not known"},
      {"record length 0", 105, raw<std::uint16_t>(0), "claim 0 bytes"},
      {"record length 29", 105, raw<std::uint16_t>(29), "claim 29 bytes"},
      {"record length 65535", 105, raw<std::uint16_t>(65535), "record 0"},
      {"scale 0", 131, raw(0.0), "the scale of x is 0"},
      {"scale nan", 139, raw(nan), "the scale of y is"},
      {"scale inf", 147, raw(inf), "the scale of z is inf"},
      {"offset inf", 155, raw(-inf), "the offset of x is -inf"},
      {"extended records beyond the file", 243, raw<std::uint32_t>(9), "extended variable length record 0 of 9"},
      {"2^64 - 1 points", 247, raw<std::uint64_t>(UINT64_MAX), "promises 18446744073709551615 records"},
      {"2^61 points", 247, raw<std::uint64_t>(std::uint64_t{1} << 61), "record 3"}};
  for (const auto& wrong : wrongs) {
    auto bytes = small_file(4, 6, 0).bytes();
    put<std::uint64_t>(bytes, 235, bytes.size() + 1);
    std::copy(wrong.value.begin(), wrong.value.end(), bytes.begin() + static_cast<std::ptrdiff_t>(wrong.at));
    const auto read = read_bytes(bytes, "a.las");
    ASSERT_TRUE(read.has_error()) << wrong.what;
    EXPECT_EQ(read.error().code, Errc::bad_input);
    EXPECT_NE(read.error().where.find(wrong.part_of_sentence), std::string::npos)
        << wrong.what << ": " << read.error().where;
  }
}

TEST(LasReader, DoesNotBelieveABoxThatIsNone) {
  auto bytes = small_file(2, 0, 0).bytes();
  EXPECT_TRUE(read_bytes(bytes, "a.las").value().info.bounds.has_value()) << "all zero is a box";
  put(bytes, 187, 1e9);
  EXPECT_FALSE(read_bytes(bytes, "a.las").value().info.bounds.has_value());
  put(bytes, 187, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(read_bytes(bytes, "a.las").value().info.bounds.has_value());
}

// A header whose offset and scale leave the doubles: the reader passes infinity on, the cloud refuses it.
TEST(LasReader, GivesInfinityWhereADecimalIsTooLarge) {
  auto file = small_file(2, 0, 0);
  file.scale = {1e300, 1, 1};
  file.offset = {1e308, 0, 0};
  const auto read = read_bytes(file.bytes(), "a.las");
  ASSERT_EQ(sentence(read), "");
  EXPECT_TRUE(std::isinf(read.value().points[2].x));
}

}  // namespace
}  // namespace tessera::testing_io
