// Copies of real files, and of files made by hand: everything but what was asked for is that of the input.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "src/base/ledger.h"
#include "src/input/cloud/cloud.h"
#include "src/input/las_copy/las_copy.h"
#include "tests/input/las_file.h"
#include "tests/input/laz_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

namespace fs = std::filesystem;

// A file by its parts, found without the product's code.
struct Parts {
  struct Record {
    std::string user;
    std::uint16_t id = 0;
    Bytes head, payload;  // the head without the length
    bool of_laz() const { return user == "laszip encoded" || user == "copc"; }
    bool extra_bytes() const { return user == "LASF_Spec" && id == 4; }
  };
  Bytes header;  // without places, lengths and what depends on compression
  std::vector<Record> records, extended;
  Bytes gap;
};

Parts parts_of(const Bytes& file) {
  Parts parts;
  const bool has_extended = load<std::uint8_t>(file.data() + 25) >= 4;
  std::size_t at = load<std::uint16_t>(file.data() + 94);
  parts.header.assign(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(at));
  for (std::size_t i = 96; i < 107; ++i) parts.header[i] = std::byte{0};
  for (std::size_t i = 227; has_extended && i < 247; ++i) parts.header[i] = std::byte{0};
  const auto take = [&](bool extended) {
    const std::size_t head = extended ? 60 : 54;
    Parts::Record record;
    record.head.assign(file.begin() + static_cast<std::ptrdiff_t>(at),
                       file.begin() + static_cast<std::ptrdiff_t>(at + head));
    const auto bytes =
        extended ? load<std::uint64_t>(file.data() + at + 20) : load<std::uint16_t>(file.data() + at + 20);
    record.user = reinterpret_cast<const char*>(file.data() + at + 2);
    record.user.resize(std::min<std::size_t>(record.user.size(), 16));
    record.id = load<std::uint16_t>(file.data() + at + 18);
    for (std::size_t i = 20; i < (extended ? 28u : 22u); ++i) record.head[i] = std::byte{0};
    at += head;
    record.payload.assign(file.begin() + static_cast<std::ptrdiff_t>(at),
                          file.begin() + static_cast<std::ptrdiff_t>(at + bytes));
    at += bytes;
    return record;
  };
  for (auto i = load<std::uint32_t>(file.data() + 100); i > 0; --i) parts.records.push_back(take(false));
  parts.gap.assign(file.begin() + static_cast<std::ptrdiff_t>(at),
                   file.begin() + load<std::uint32_t>(file.data() + 96));
  if (!has_extended) return parts;
  at = load<std::uint64_t>(file.data() + 235);
  for (auto i = load<std::uint32_t>(file.data() + 243); i > 0; --i) parts.extended.push_back(take(true));
  return parts;
}

void expect_same_records(std::vector<Parts::Record> found, std::vector<Parts::Record> expected, bool without_extra) {
  for (auto* records : {&found, &expected})
    std::erase_if(*records, [&](const auto& r) { return r.of_laz() || (without_extra && r.extra_bytes()); });
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].head, expected[i].head) << "record " << i;
    EXPECT_EQ(found[i].payload, expected[i].payload) << "record " << i;
  }
}

void expect_same_parts(const fs::path& copy, const fs::path& original, bool without_extra = false) {
  const Parts found = parts_of(file_bytes(copy)), expected = parts_of(file_bytes(original));
  EXPECT_EQ(found.header, expected.header);
  EXPECT_EQ(found.gap, expected.gap);
  expect_same_records(found.records, expected.records, without_extra);
  expect_same_records(found.extended, expected.extended, without_extra);
}

void expect_same_points(const fs::path& copy, const fs::path& original) {
  const auto found = read_records(copy, all_fields), expected = read_records(original, all_fields);
  ASSERT_EQ(sentence(found), "");
  ASSERT_EQ(sentence(expected), "");
  ASSERT_EQ(found.value().header.record_bytes, expected.value().header.record_bytes);
  EXPECT_TRUE(found.value().bytes == expected.value().bytes);
  const auto schema = open_reader(original).value()->info().attributes;
  EXPECT_EQ(open_reader(copy).value()->info().attributes, schema);
  const auto read = read_path(copy, schema), twin = read_path(original, schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_TRUE(read.value().points == twin.value().points);
  EXPECT_TRUE(read.value().rows == twin.value().rows);
  EXPECT_EQ(read.value().info.crs, twin.value().info.crs);
}

// One value for a rank and a dimension, among them those that are no numbers and those of very different sizes.
double value_of(std::uint64_t rank, std::size_t dimension) {
  if (rank % 1000 == 17) return std::numeric_limits<double>::quiet_NaN();
  if (rank % 1000 == 18) return -std::numeric_limits<double>::infinity();
  return std::sin(static_cast<double>(rank) * 0.01) * (rank % 1000 == 19 ? 1e30 : 20.0) +
         static_cast<double>(dimension);
}

DimensionValues values_of(std::size_t dimensions) {
  return [dimensions, next = std::uint64_t{0}](std::uint64_t first, std::span<double> values) mutable -> Status {
    EXPECT_EQ(first, next);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = value_of(first + i / dimensions, i % dimensions);
    next += values.size() / dimensions;
    return success();
  };
}

const ExtraDimension height{"HeightAboveGround", "height above ground", AttributeType::f32};
const ExtraDimension height_64{"HeightAboveGround", "height above ground", AttributeType::f64};
const ExtraDimension other_64{"other", "", AttributeType::f64};

Result<std::uint64_t> make_copy(const fs::path& from, const fs::path& to, const LasCopyOptions& options = {}) {
  BOOST_OUTCOME_TRY(source, open_file(from));
  return copy_las(std::move(source), to, options, values_of(options.dimensions.size()));
}

// Whether the columns `names` of all points have the values of value_of().
void expect_values(const fs::path& path, const std::vector<Attribute>& schema) {
  const auto read = read_path(path, schema);
  ASSERT_EQ(sentence(read), "");
  for (std::size_t i = 0; i < read.value().points.size(); ++i)
    for (std::size_t k = 0; k < schema.size(); ++k) {
      const double expected = value_of(i, k);
      if (schema[k].type == AttributeType::f32) {
        const auto single = static_cast<float>(expected);
        ASSERT_EQ(std::bit_cast<std::uint32_t>(cell<float>(read.value(), schema, i, k)),
                  std::bit_cast<std::uint32_t>(single))
            << "point " << i;
      } else {
        ASSERT_EQ(std::bit_cast<std::uint64_t>(cell<double>(read.value(), schema, i, k)),
                  std::bit_cast<std::uint64_t>(expected))
            << "point " << i;
      }
    }
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

std::vector<RealCloud> las_files(const fs::path& folder) {
  std::vector<RealCloud> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (name.ends_with(".las") || name.ends_with(".laz")) files.push_back({folder, name});
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return files;
}

// Those that every clone has, with this ending.
std::vector<RealCloud> bundled(std::string_view ending = "") {
  auto files = las_files(clouds);
  std::erase_if(files, [&](const auto& file) { return !file.name.ends_with(ending); });
  return files;
}

std::vector<RealCloud> all_laz_files() {
  auto files = bundled(".laz");
  if (!has_more_clouds()) return files;
  for (const auto& file : las_files(more_clouds))
    if (file.name.ends_with(".laz")) files.push_back(file);
  return files;
}

class CopyOf : public testing::TestWithParam<RealCloud> {
 protected:
  fs::path original() const { return GetParam().path(); }
  bool compressed() const { return original().extension() == ".laz"; }
  fs::path to(const std::string& name) const { return folder_.path() / name; }
  std::vector<fs::path> left() const { return files_in(folder_.path()); }

 private:
  TempFolder folder_;
};

TEST_P(CopyOf, HasEverythingOfTheOriginalInAllPackings) {
  const std::vector<std::pair<LasPacking, fs::path>> copies{
      {LasPacking::as_input, to("same")}, {LasPacking::las, to("a.las")}, {LasPacking::laz, to("a.laz")}};
  for (const auto& [packing, path] : copies) {
    const auto done = make_copy(original(), path, {.packing = packing});
    ASSERT_EQ(sentence(done), "");
    EXPECT_EQ(done.value(), read_records(original(), all_fields).value().size());
    expect_same_parts(path, original());
    expect_same_points(path, original());
  }
  EXPECT_EQ(left().size(), 3u);
  const LasHeader plain = read_records(to("a.las"), all_fields).value().header;
  EXPECT_FALSE(plain.compressed);
  EXPECT_TRUE(plain.laszip.empty());
  EXPECT_TRUE(read_records(to("a.laz"), all_fields).value().header.compressed);
  EXPECT_EQ(file_bytes(to("same")), file_bytes(compressed() ? to("a.laz") : to("a.las")));
}

class CopyOfLas : public CopyOf {};

TEST_P(CopyOfLas, IsTheSameBytes) {
  ASSERT_EQ(sentence(make_copy(original(), to("a.las"))), "");
  EXPECT_TRUE(file_bytes(to("a.las")) == file_bytes(original()));
}

class CopyOfLaz : public CopyOf {};

// The points of a compressed file, up to the chunk table.
Bytes compressed_points(const Bytes& file) {
  const auto begin = load<std::uint32_t>(file.data() + 96);
  return {file.begin() + begin, file.begin() + load<std::int64_t>(file.data() + begin)};
}

// The encoder has a choice only where GPS times leap, and it chooses as LASzip does.
TEST_P(CopyOfLaz, IsWhatOtherWritersMadeToTheLastBit) {
  ASSERT_EQ(sentence(make_copy(original(), to("a.laz"))), "");
  const Bytes found = file_bytes(to("a.laz")), expected = file_bytes(original());
  EXPECT_TRUE(compressed_points(found) == compressed_points(expected));
  // The chunk table of a file that was cut is not LASzip's, and others have bytes behind it.
  EXPECT_LE(found.size(), expected.size());
  EXPECT_GE(found.size() + 32, expected.size());
}

TEST_P(CopyOf, HasOneDimensionMore) {
  for (const auto& dimensions : {std::vector{height}, std::vector{height_64, other_64}}) {
    for (const auto packing : {LasPacking::las, LasPacking::laz}) {
      const auto path = to(packing == LasPacking::las ? "a.las" : "a.laz");
      ASSERT_EQ(sentence(make_copy(original(), path, {.packing = packing, .dimensions = dimensions})), "");
      expect_same_parts(path, original(), true);
      auto schema = open_reader(original()).value()->info().attributes;
      const auto read = read_path(path, schema), twin = read_path(original(), schema);
      ASSERT_EQ(sentence(read), "");
      EXPECT_TRUE(read.value().points == twin.value().points);
      EXPECT_TRUE(read.value().rows == twin.value().rows);
      std::vector<Attribute> added;
      for (const auto& dimension : dimensions) added.push_back({dimension.name, dimension.type});
      schema.insert(schema.end(), added.begin(), added.end());
      EXPECT_EQ(read.value().info.attributes, schema);
      expect_values(path, added);
    }
  }
}

TEST_P(CopyOf, HasADimensionOnlyOnce) {
  ASSERT_EQ(
      sentence(make_copy(original(), to("once.laz"), {.packing = LasPacking::laz, .dimensions = {height, other_64}})),
      "");
  EXPECT_EQ(sentence(make_copy(to("once.laz"), to("twice.laz"), {.dimensions = {height_64}})),
            to("once.laz").string() + ", extra bytes: the points already have a dimension 'HeightAboveGround'");
  EXPECT_EQ(left().size(), 1u);
  // The other dimension, which stands behind the one that is replaced, keeps its values.
  ASSERT_EQ(sentence(make_copy(to("once.laz"), to("once.laz"), {.dimensions = {height_64}, .replace = true})), "");
  expect_values(to("once.laz"), {{"HeightAboveGround", AttributeType::f64}, {"other", AttributeType::f64}});
  auto schema = open_reader(original()).value()->info().attributes;
  schema.push_back({"other", AttributeType::f64});
  schema.push_back({"HeightAboveGround", AttributeType::f64});
  EXPECT_EQ(open_reader(to("once.laz")).value()->info().attributes, schema);
}

INSTANTIATE_TEST_SUITE_P(LasCopy, CopyOf, testing::ValuesIn(bundled()));
INSTANTIATE_TEST_SUITE_P(LasCopy, CopyOfLas, testing::ValuesIn(bundled(".las")));
INSTANTIATE_TEST_SUITE_P(LasCopy, CopyOfLaz, testing::ValuesIn(all_laz_files()));

class CopyOfCopc : public CopyOf {};

TEST_P(CopyOfCopc, IsAHierarchyWithTheSamePointsEverywhere) {
  ASSERT_EQ(sentence(make_copy(original(), to("a.copc.laz"), {.dimensions = {height}})), "");
  const Bounds bounds = open_reader(original()).value()->info().bounds.value();
  const double middle = (bounds.lo[0] + bounds.hi[0]) / 2, side = bounds.hi[0] - bounds.lo[0];
  const Box half{{bounds.lo[0], bounds.lo[1], bounds.lo[2]}, {middle, bounds.hi[1], bounds.hi[2]}};
  for (const double resolution : {0.0, side, side / 256, side / 1000}) {
    const ReadHints hints{.crop = half, .resolution = resolution};
    const auto found = read_whole(*open_reader(to("a.copc.laz"), {}, hints).value());
    const auto expected = read_whole(*open_reader(original(), {}, hints).value());
    ASSERT_EQ(sentence(found), "");
    EXPECT_TRUE(found.value().info.levels);
    EXPECT_GT(expected.value().points.size(), 0u);
    EXPECT_TRUE(found.value().points == expected.value().points);
  }
}

INSTANTIATE_TEST_SUITE_P(LasCopy, CopyOfCopc,
                         testing::ValuesIn(real_clouds({"ellipsoid.copc.laz", "lone_star_part.copc.laz",
                                                        "lion_takanawa_part.copc.laz"},
                                                       {"lone_star.copc.laz", "lion_takanawa.copc.laz"})));

LasFile some_file(int minor, std::uint8_t format, std::uint16_t extra_bytes) {
  LasFile file;
  file.minor = minor;
  file.format = format;
  file.extra_bytes = extra_bytes;
  for (int i = 0; i < 300; ++i) file.points.push_back({i, 1000 - i, i * i});
  return file;
}

Bytes descriptor(std::uint8_t kind, std::uint8_t options, std::string_view name) {
  Bytes bytes(192);
  put(bytes, 2, kind);
  put(bytes, 3, options);
  std::memcpy(bytes.data() + 4, name.data(), name.size());
  return bytes;
}

class CopyByHand : public testing::Test {
 protected:
  fs::path write(const LasFile& file) const { return folder_.write("in.las", file.bytes()); }
  fs::path to() const { return folder_.path() / "out.laz"; }
  const TempFolder& folder() const { return folder_; }
  void expect_nothing_new() const { EXPECT_EQ(files_in(folder_.path()).size(), 1u); }

 private:
  TempFolder folder_;
};

TEST_F(CopyByHand, KeepsRecordsOnBothSidesOfThePoints) {
  for (const std::uint8_t format : {0, 1, 2, 3, 6, 7, 8}) {
    auto file = some_file(4, format, 3);
    file.records = {{"somebody", 7, bytes_of("abc")}, {"somebody", 8, {}}, {"LASF_Spec", 4, descriptor(0, 3, "")}};
    file.extended = {{"else", 9, Bytes(70'000, std::byte{5})}, {"else", 10, bytes_of("x")}};
    auto bytes = file.bytes();
    const std::size_t points_end = file.points_at() + file.points.size() * file.record_bytes();
    put<std::uint64_t>(bytes, 227, points_end);  // waveforms in the first extended record
    const auto in = folder().write("in.las", bytes);
    for (const auto packing : {LasPacking::las, LasPacking::laz}) {
      ASSERT_EQ(sentence(make_copy(in, to(), {.packing = packing, .dimensions = {height}})), "");
      expect_same_parts(to(), in, true);
      const Bytes out = file_bytes(to());
      EXPECT_EQ(load<std::uint64_t>(out.data() + 227), load<std::uint64_t>(out.data() + 235));
    }
  }
}

TEST_F(CopyByHand, TellsTheLeastAndTheGreatestValueThatIsStored) {
  for (const bool behind : {false, true}) {
    auto file = some_file(4, 6, 1);
    (behind ? file.extended : file.records) = {{"LASF_Spec", 4, descriptor(1, 0, "first")}};
    const auto in = write(file);
    for (const auto packing : {LasPacking::las, LasPacking::laz})
      for (const auto& dimension : {height, height_64}) {
        double least = HUGE_VAL, greatest = -HUGE_VAL;
        for (std::uint64_t i = 0; i < file.points.size(); ++i) {
          double value = value_of(i, 0);
          if (dimension.type == AttributeType::f32) value = static_cast<double>(static_cast<float>(value));
          if (value < least) least = value;
          if (value > greatest) greatest = value;
        }
        ASSERT_EQ(sentence(make_copy(in, to(), {.packing = packing, .dimensions = {dimension}})), "");
        const Parts parts = parts_of(file_bytes(to()));
        const auto& records = behind ? parts.extended : parts.records;
        const auto found = std::find_if(records.begin(), records.end(), [](const auto& r) { return r.extra_bytes(); });
        ASSERT_NE(found, records.end());
        ASSERT_EQ(found->payload.size(), 2u * 192);
        EXPECT_EQ(found->payload[3], std::byte{0});
        EXPECT_EQ(found->payload[192 + 3], std::byte{6});
        EXPECT_EQ(load<double>(found->payload.data() + 192 + 64), least);
        EXPECT_EQ(load<double>(found->payload.data() + 192 + 88), greatest);
      }
  }
}

TEST_F(CopyByHand, TellsNoRangeOfValuesThatAreNoNumbers) {
  const auto in = write(some_file(2, 0, 0));
  auto source = open_file(in);
  const auto unknown = [](std::uint64_t, std::span<double> values) -> Status {
    for (auto& value : values) value = std::numeric_limits<double>::quiet_NaN();
    return success();
  };
  ASSERT_EQ(sentence(copy_las(std::move(source).value(), to(), {.dimensions = {height}}, unknown)), "");
  const Parts parts = parts_of(file_bytes(to()));
  ASSERT_EQ(parts.records.size(), 1u);
  EXPECT_EQ(parts.records[0].payload[3], std::byte{0});
}

// The record of waveforms is in the list of extended records since LAS 1.4; in LAS 1.3 the header alone tells of it.
TEST_F(CopyByHand, KeepsWaveforms) {
  for (const int minor : {3, 4})
    for (const std::uint8_t format : {4, 5, 9, 10}) {
      if (minor == 3 && format > 5) continue;
      auto file = some_file(minor, format, 2);
      const Bytes waveforms(70'000, std::byte{7});
      file.records = {{"LASF_Spec", 100, Bytes(26, std::byte{1})}};
      file.extended = {{"LASF_Spec", 65535, waveforms}};
      // Before the waveforms, a record that grows.
      if (minor == 4) file.extended.insert(file.extended.begin(), {"LASF_Spec", 4, descriptor(1, 0, "first")});
      auto bytes = file.bytes();
      const std::size_t begin = bytes.size() - 60 - waveforms.size();
      put<std::uint16_t>(bytes, 6, 2);
      put<std::uint64_t>(bytes, 227, begin);
      const auto in = folder().write("in.las", bytes);
      ASSERT_EQ(sentence(make_copy(in, to(), {.dimensions = {height}})), "");
      const Bytes out = file_bytes(to());
      const auto now = load<std::uint64_t>(out.data() + 227);
      ASSERT_EQ(now + 60 + waveforms.size(), out.size());
      EXPECT_TRUE(std::equal(out.begin() + static_cast<std::ptrdiff_t>(now), out.end(),
                             bytes.begin() + static_cast<std::ptrdiff_t>(begin)));
      expect_values(to(), {{"HeightAboveGround", AttributeType::f32}});
      const auto records = read_records(to(), all_fields), before = read_records(in, all_fields);
      const std::size_t stride = file.record_bytes();
      for (std::size_t i = 0; i < file.points.size(); ++i)
        ASSERT_TRUE(std::equal(before.value().bytes.begin() + static_cast<std::ptrdiff_t>(i * stride),
                               before.value().bytes.begin() + static_cast<std::ptrdiff_t>(i * stride + stride),
                               records.value().bytes.begin() + static_cast<std::ptrdiff_t>(i * (stride + 4))));
      const auto packed = make_copy(in, folder().path() / "packed.laz", {.packing = LasPacking::laz});
      EXPECT_NE(sentence(packed).find("which hold waveforms; these are copied only from LAS to LAS"),
                std::string::npos);
      put<std::uint64_t>(bytes, 227, begin - 100);
      folder().write("in.las", bytes);
      EXPECT_NE(sentence(make_copy(in, to())).find("but no record of waveforms begins there"), std::string::npos);
    }
}

TEST_F(CopyByHand, DescribesBytesThatNothingDescribed) {
  for (const std::uint16_t extra : {1, 255, 256, 600}) {
    const auto in = write(some_file(2, 1, extra));
    for (const auto packing : {LasPacking::las, LasPacking::laz}) {
      ASSERT_EQ(sentence(make_copy(in, to(), {.packing = packing, .dimensions = {height}})), "");
      expect_values(to(), {{"HeightAboveGround", AttributeType::f32}});
      const auto records = read_records(to(), all_fields), before = read_records(in, all_fields);
      const std::size_t stride = 28u + extra;
      for (std::size_t i = 0; i < 300; ++i)
        ASSERT_TRUE(std::equal(before.value().bytes.begin() + static_cast<std::ptrdiff_t>(i * stride),
                               before.value().bytes.begin() + static_cast<std::ptrdiff_t>((i + 1) * stride),
                               records.value().bytes.begin() + static_cast<std::ptrdiff_t>(i * (stride + 4))));
    }
  }
}

TEST_F(CopyByHand, GoesOnInTheLastRecordOfExtraBytes) {
  auto file = some_file(4, 6, 7);
  file.records = {{"LASF_Spec", 4, descriptor(1, 0, "first")}};
  file.extended = {{"LASF_Spec", 4, descriptor(3, 0, "second")}, {"else", 1, {}}};
  ASSERT_EQ(sentence(make_copy(write(file), to(), {.packing = LasPacking::laz, .dimensions = {height}})), "");
  expect_values(to(), {{"HeightAboveGround", AttributeType::f32}});
  const auto attributes = open_reader(to()).value()->info().attributes;
  ASSERT_GE(attributes.size(), 3u);
  EXPECT_EQ(attributes[attributes.size() - 3].name, "first");
  EXPECT_EQ(attributes[attributes.size() - 2].name, "second");
}

TEST_F(CopyByHand, SaysWhichDimensionsAndFilesCannotBeContinued) {
  const auto refused = [&](const LasFile& file, LasPacking packing = LasPacking::las) {
    const auto done = make_copy(write(file), to(), {.packing = packing, .dimensions = {height}});
    EXPECT_TRUE(done.has_error());
    EXPECT_EQ(done.error().code, Errc::bad_input);
    expect_nothing_new();
    return sentence(done).substr((folder().path() / "in.las").string().size());
  };
  auto file = some_file(2, 0, 4);
  file.records = {{"LASF_Spec", 4, descriptor(31, 0, "odd")}};
  EXPECT_EQ(refused(file), ", extra bytes: the dimension 'odd' is of kind 31, whose size is not known; 0 to 30 are");
  file.records = {{"LASF_Spec", 4, descriptor(10, 0, "long")}};
  EXPECT_EQ(refused(file), ", extra bytes: the dimension 'long' ends behind the point record, which has 24 bytes");
  file = some_file(2, 0, 341);
  Bytes many;
  for (int i = 0; i < 341; ++i) {
    const Bytes one = descriptor(1, 0, "n" + std::to_string(i));
    many.insert(many.end(), one.begin(), one.end());
  }
  file.records = {{"LASF_Spec", 4, many}};
  EXPECT_EQ(refused(file), ", extra bytes: the record that describes them has no room for 342 dimensions");
  file = some_file(2, 0, 2047);
  EXPECT_EQ(refused(file, LasPacking::laz),
            ": its points would have 2051 extra bytes; LAZ is written with at most 2048");
  file = some_file(2, 0, 65'515);
  EXPECT_EQ(refused(file),
            ", extra bytes: point records of 65539 bytes would be longer than LAS permits, which is 65535");
}

TEST_F(CopyByHand, HasNoDimensionWithoutANameOrWithALongOne) {
  const auto in = write(some_file(2, 0, 0));
  const std::string long_name(33, 'a');
  for (const ExtraDimension& wrong : {ExtraDimension{"", ""}, {long_name, ""}, {"a", long_name}}) {
    const auto done = make_copy(in, to(), {.dimensions = {wrong}});
    EXPECT_EQ(done.error().code, Errc::usage);
    EXPECT_NE(sentence(done).find("a name has 1 to 32 bytes, a description at most 32"), std::string::npos);
    expect_nothing_new();
  }
  const ExtraDimension longest{std::string(32, 'a'), std::string(32, 'b'), AttributeType::f64};
  ASSERT_EQ(sentence(make_copy(in, to(), {.dimensions = {longest}})), "");
  expect_values(to(), {{longest.name, AttributeType::f64}});
}

TEST_F(CopyByHand, OfAFileWithoutPointsHasNone) {
  auto file = some_file(4, 7, 0);
  file.points.clear();
  file.extended = {{"else", 9, bytes_of("abc")}};
  const auto in = write(file);
  for (const auto packing : {LasPacking::las, LasPacking::laz}) {
    EXPECT_EQ(make_copy(in, to(), {.packing = packing, .dimensions = {height}}).value(), 0u);
    expect_same_parts(to(), in, true);
    EXPECT_EQ(read_path(to()).value().points.size(), 0u);
  }
}

TEST_F(CopyByHand, LeavesNothingWhenTheInputIsDamaged) {
  const auto whole = file_bytes(clouds / "laz_perf/extrabytes.laz");
  const auto in = folder().write("in.las", whole);
  std::size_t refused = 0;
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 20) {
    folder().write("in.las", Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    const auto done = make_copy(in, to(), {.dimensions = {height}});
    ASSERT_TRUE(done.has_error());
    EXPECT_EQ(done.error().code, Errc::bad_input);
    EXPECT_EQ(sentence(done).substr(0, in.string().size()), in.string());
    expect_nothing_new();
    ++refused;
  }
  EXPECT_GT(refused, 50u);
}

// 200 points of formats 1 and 3, not chunked; a chunk of 256 of format 7, whose items have version 4.
const fs::path small = TESSERA_TEST_DATA "/../fuzz/corpus/laz";
const std::vector<std::string> small_files{"lone_star.laz", "autzen_trim.laz", "pdrf7-v4-1.4.laz"};

TEST_F(CopyByHand, OfPointsThatAreNotChunkedHasChunks) {
  for (const auto& name : small_files)
    for (const auto packing : {LasPacking::las, LasPacking::laz}) {
      ASSERT_EQ(sentence(make_copy(small / name, to(), {.packing = packing})), "") << name;
      expect_same_parts(to(), small / name);
      expect_same_points(to(), small / name);
    }
}

TEST_F(CopyByHand, OfAFileWithWrongBitsIsRefusedOrReadAsTheInputIs) {
  std::mt19937_64 random(11);
  std::size_t refused = 0, copied = 0;
  for (const auto& name : small_files) {
    const auto whole = file_bytes(small / name);
    for (int trial = 0; trial < 200; ++trial) {
      auto bytes = whole;
      for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
        // half of them in the header and the records of variable length
        const std::size_t at = random() % (trial % 2 == 0 ? std::min<std::size_t>(bytes.size(), 1500) : bytes.size());
        bytes[at] ^= std::byte{1} << random() % 8;
      }
      const auto in = folder().write("in.las", bytes);
      std::error_code ignored;
      fs::remove(to(), ignored);
      const auto done = make_copy(in, to(), {.packing = LasPacking::laz, .dimensions = {height}});
      if (done.has_error()) {
        ++refused;
        expect_nothing_new();
        continue;
      }
      ++copied;
      const auto found = read_path(to()), expected = read_path(in);
      ASSERT_EQ(sentence(found), "");
      ASSERT_TRUE(found.value().points == expected.value().points);
    }
  }
  EXPECT_GT(refused, 200u);
  EXPECT_GT(copied, 50u);
}

TEST_F(CopyByHand, DoesNotDependOnTheNumberOfThreads) {
  const auto in = clouds / "lone_star_part.copc.laz";
  const auto one = folder().path() / "one.laz";
  ASSERT_EQ(sentence(make_copy(in, one, {.dimensions = {height}})), "");
  ASSERT_EQ(sentence(make_copy(in, to(), {.dimensions = {height}, .threads = 4})), "");
  EXPECT_TRUE(file_bytes(to()) == file_bytes(one));
}

TEST_F(CopyByHand, LeavesNothingWhenItIsStoppedOrTheValuesFailOrTheLedgerIsUsedUp) {
  const auto in = write(some_file(2, 1, 0));
  std::stop_source stop;
  const auto stopped = copy_las(open_file(in).value(), to(), {.dimensions = {height}, .stop = stop.get_token()},
                                [&](std::uint64_t, std::span<double>) -> Status {
                                  stop.request_stop();
                                  return success();
                                });
  EXPECT_EQ(stopped.error().code, Errc::interrupted);
  expect_nothing_new();
  const auto failed =
      copy_las(open_file(in).value(), to(), {.dimensions = {height}},
               [](std::uint64_t, std::span<double>) -> Status { return error(Errc::memory, "no values"); });
  EXPECT_EQ(sentence(failed), "no values");
  expect_nothing_new();
  for (const std::uint64_t most : {0u, 100u, 5000u, 9000u}) {
    Ledger ledger({.disk = {most, "the disk,"}});
    const Ledger::Use use(&ledger);
    EXPECT_EQ(make_copy(in, to(), {.dimensions = {height}}).error().code, Errc::memory) << most;
    expect_nothing_new();
  }
}

}  // namespace
}  // namespace tessera::testing_io
