// Items of version 1, which LASzip wrote until 2011 and no real file at hand has.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/las_copy/integer_encoder.h"
#include "src/input/las_copy/las_copy.h"
#include "src/input/laz/laz_layout.h"
#include "tests/input/las_file.h"
#include "tests/input/laz_testing.h"

namespace tessera::testing_io {
namespace {

using laz::ArithmeticEncoder;
using laz::IntegerEncoder;

constexpr std::size_t record_bytes = 36;  // format 3 and two extra bytes

// Encodes records of point format 3 with two extra bytes, one after the other.
class Version1Encoder {
 public:
  explicit Version1Encoder(const std::byte* first) { std::copy_n(first, record_bytes, last_.begin()); }

  void next(const std::byte* record) {
    point(record);
    time(load<std::int64_t>(record + 20));
    colour(record + 28);
    for (std::uint32_t i = 34; i < record_bytes; ++i)
      extra_.next(encoder_, byte(last_.data(), i), byte(record, i), i - 34);
    std::copy_n(record, record_bytes, last_.begin());
  }
  Bytes finish() { return encoder_.finish(); }

 private:
  static std::uint8_t byte(const std::byte* record, std::size_t at) {
    return std::to_integer<std::uint8_t>(record[at]);
  }
  static std::int32_t median(std::array<std::int32_t, 3> v) {
    std::sort(v.begin(), v.end());
    return v[1];
  }

  void point(const std::byte* r) {
    const auto* l = last_.data();
    const auto dx = static_cast<std::int32_t>(load<std::uint32_t>(r) - load<std::uint32_t>(l));
    const auto dy = static_cast<std::int32_t>(load<std::uint32_t>(r + 4) - load<std::uint32_t>(l + 4));
    x_.next(encoder_, median(dx_), dx);
    y_.next(encoder_, median(dy_), dy, std::min(x_.length(), 19u));
    const std::uint32_t length = (x_.length() + y_.length()) / 2;
    z_.next(encoder_, load<std::int32_t>(l + 8), load<std::int32_t>(r + 8), std::min(length, 19u));
    dx_[turn_ % 3] = dx;
    dy_[turn_++ % 3] = dy;
    const std::array<std::array<std::size_t, 2>, 6> fields{{{18, 2}, {17, 1}, {16, 1}, {15, 1}, {14, 1}, {12, 2}}};
    std::uint32_t changed = 0;
    for (std::size_t i = 0; i < fields.size(); ++i)
      changed |= std::uint32_t{!std::equal(l + fields[i][0], l + fields[i][0] + fields[i][1], r + fields[i][0])} << i;
    encoder_.symbol(changed_, changed);
    const auto by_last = [&](auto& models, std::size_t at) { encoder_.symbol(models[byte(l, at)], byte(r, at)); };
    if ((changed & 32) != 0) intensity_.next(encoder_, load<std::uint16_t>(l + 12), load<std::uint16_t>(r + 12));
    if ((changed & 16) != 0) by_last(returns_, 14);
    if ((changed & 8) != 0) by_last(classes_, 15);
    if ((changed & 4) != 0) angle_.next(encoder_, byte(l, 16), byte(r, 16), length < 3);
    if ((changed & 2) != 0) by_last(user_, 17);
    if ((changed & 1) != 0) source_.next(encoder_, load<std::uint16_t>(l + 18), load<std::uint16_t>(r + 18));
  }

  void time(std::int64_t now) {
    const auto last = load<std::int64_t>(last_.data() + 20);
    const std::int64_t moved = now - last;
    const bool fits = moved == static_cast<std::int32_t>(moved);
    const auto raw = [&] {
      encoder_.bits(static_cast<std::uint32_t>(now), 32);
      encoder_.bits(static_cast<std::uint32_t>(now >> 32), 32);
    };
    const auto difference = static_cast<std::int32_t>(moved);
    if (usual_ == 0) {
      encoder_.symbol(first_times_, moved == 0 ? 0 : fits ? 1 : 2);
      if (moved != 0 && fits) times_.next(encoder_, 0, usual_ = difference, 0);
      if (!fits) raw();
      return;
    }
    if (moved == 0) return encoder_.symbol(multiples_, 511);
    if (!fits) {
      encoder_.symbol(multiples_, 510);
      return raw();
    }
    const auto multiple = static_cast<std::int32_t>(std::clamp(std::round(double(difference) / usual_), 0.0, 509.0));
    encoder_.symbol(multiples_, static_cast<std::uint32_t>(multiple));
    const std::uint32_t context = multiple == 1 ? 1 : multiple == 0 ? 2 : multiple < 10 ? 3 : multiple < 50 ? 4 : 5;
    times_.next(encoder_, multiple == 0 ? usual_ / 4 : multiple * usual_, difference, context);
    if (multiple == 1) usual_ = difference, extremes_ = 0;
    if ((multiple == 0 || multiple == 509) && ++extremes_ > 3) usual_ = difference, extremes_ = 0;
  }

  void colour(const std::byte* now) {
    std::uint32_t changed = 0;
    for (std::size_t i = 0; i < 6; ++i) changed |= std::uint32_t{now[i] != last_[28 + i]} << i;
    encoder_.symbol(bytes_changed_, changed);
    for (std::uint32_t i = 0; i < 6; ++i)
      if ((changed >> i & 1) != 0) colours_.next(encoder_, byte(last_.data(), 28 + i), byte(now, i), i);
  }

  ArithmeticEncoder encoder_;
  std::array<std::byte, record_bytes> last_;
  std::array<std::int32_t, 3> dx_{}, dy_{};
  std::size_t turn_ = 0;
  std::int32_t usual_ = 0;
  int extremes_ = 0;
  laz::SymbolModel<64> changed_, bytes_changed_;
  std::map<std::uint8_t, laz::SymbolModel<256>> returns_, classes_, user_;
  laz::SymbolModel<3> first_times_;
  laz::SymbolModel<512> multiples_;
  IntegerEncoder<32> x_;
  IntegerEncoder<32, 20> y_, z_;
  IntegerEncoder<16> intensity_, source_;
  IntegerEncoder<8, 2> angle_, extra_;
  IntegerEncoder<8, 6> colours_;
  IntegerEncoder<32, 6> times_;
};

// Records as a scanner might make them, with rare leaps of every field, among them those that need 32 bits.
Bytes some_records(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto one_in = [&](std::uint64_t k) { return random() % k == 0; };
  Bytes records(n * record_bytes);
  std::int64_t time = 0x4100000000000000;
  for (std::size_t i = 0; i < n; ++i) {
    std::byte* r = records.data() + i * record_bytes;
    if (i > 0) std::copy_n(r - record_bytes, record_bytes, r);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto step = static_cast<std::uint32_t>(random() >> (one_in(50) ? 32 : 56));
      const std::uint32_t moved = load<std::uint32_t>(r + 4 * axis) + step - (one_in(2) ? 2 * step : 0);
      std::memcpy(r + 4 * axis, &moved, sizeof moved);
    }
    for (std::size_t at = 12; at < record_bytes; ++at)
      if ((at < 20 || at >= 28) && one_in(4)) r[at] = static_cast<std::byte>(random() >> (one_in(2) ? 56 : 61));
    // Usual steps, repeats, multiples small and large, steps back, and leaps of 64 bits.
    const std::array<std::int64_t, 8> steps{1000, 1000, 0, 7000, 30'000, 900'000, -50, std::int64_t{1} << 40};
    if (i > 0) time += steps[random() % steps.size()];
    std::memcpy(r + 20, &time, sizeof time);
  }
  return records;
}

LasFile version_1_file(std::uint16_t compressor, std::uint32_t chunk_points, std::size_t plain_points = 0) {
  LasFile file;
  file.format = 3;
  file.extra_bytes = 2;
  file.points.resize(plain_points, {1, -2, 3});
  Bytes record;
  for (const int v : {int{compressor}, 0}) push(record, static_cast<std::uint16_t>(v));
  push(record, std::uint64_t{0});  // version, options
  push(record, chunk_points);
  push(record, std::int64_t{-1});
  push(record, std::int64_t{-1});
  for (const int v : {4, 6, 20, 1, 7, 8, 1, 8, 6, 1, 0, 2, 1}) push(record, static_cast<std::uint16_t>(v));
  file.records.push_back({"laszip encoded", 22204, record});
  return file;
}

Bytes encode(const std::byte* records, std::size_t n) {
  Version1Encoder encoder(records);
  for (std::size_t i = 1; i < n; ++i) encoder.next(records + i * record_bytes);
  Bytes bytes(records, records + record_bytes);
  const Bytes rest = encoder.finish();
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

Bytes with_count(const LasFile& file, std::size_t points) {
  Bytes bytes = file.bytes();
  put(bytes, 104, std::uint8_t{0x83});
  put(bytes, 107, static_cast<std::uint32_t>(points));
  return bytes;
}

TEST(LazVersion1, GivesBackWhatWasEncoded) {
  for (const std::size_t n : {1u, 2u, 3u, 20'000u}) {
    const Bytes records = some_records(n, n);
    Bytes bytes = with_count(version_1_file(1, 0), n);
    append(bytes, encode(records.data(), n));
    const auto read = read_records(memory_source("a.laz", bytes), all_fields);
    ASSERT_EQ(sentence(read), "");
    ASSERT_EQ(read.value().size(), n);
    for (std::size_t i = 0; i < records.size(); ++i)
      ASSERT_EQ(read.value().bytes[i], records[i]) << "record " << i / record_bytes << " byte " << i % record_bytes;
  }
}

TEST(LazVersion1, IsCopiedAsVersion2) {
  const Bytes records = some_records(1000, 3);
  Bytes bytes = with_count(version_1_file(1, 0), 1000);
  append(bytes, encode(records.data(), 1000));
  const TempFolder folder;
  const auto copied = copy_las(memory_source("a.laz", bytes), folder.path() / "b.laz", {}, {});
  ASSERT_EQ(sentence(copied), "");
  const auto read = read_records(folder.path() / "b.laz", all_fields);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().bytes, records);
  const auto layout = laz::read_laz_layout("b.laz", read.value().header.laszip, 3, record_bytes);
  ASSERT_EQ(sentence(layout), "");
  EXPECT_EQ(layout.value().compressor, laz::Compressor::pointwise_chunked);
  for (const auto& item : layout.value().items) EXPECT_EQ(item.version, 2);
}

TEST(LazVersion1, MayAlsoBeARecordThatSaysThatNothingIsCompressed) {
  const auto file = version_1_file(0, 0, 5);
  const auto plain = read_records(memory_source("a.las", file.bytes()), all_fields);
  const auto read = read_records(memory_source("a.laz", with_count(file, 5)), all_fields);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().size(), 5u);
  EXPECT_EQ(read.value().bytes, plain.value().bytes);
  const TempFolder folder;
  ASSERT_EQ(sentence(copy_las(memory_source("a.laz", with_count(file, 5)), folder.path() / "b.laz", {}, {})), "");
  EXPECT_EQ(read_records(folder.path() / "b.laz", all_fields).value().bytes, plain.value().bytes);
  EXPECT_EQ(sentence(read_records(memory_source("a.laz", with_count(file, 6)), all_fields)),
            "a.laz, record 5: the file ends before or within this record, but its header promises 6 records");
}

TEST(LazVersion1, GivesBackChunksOfOneSizeAndOfSeveral) {
  const std::vector<std::uint32_t> sizes{100, 100, 100, 37};
  for (const bool variable : {false, true}) {
    const Bytes records = some_records(337, 5);
    Bytes bytes = with_count(version_1_file(2, variable ? UINT32_MAX : 100), 337);
    const std::size_t points_at = bytes.size();
    push(bytes, std::int64_t{0});
    ArithmeticEncoder table;
    IntegerEncoder<32, 2> integers;
    std::size_t first = 0;
    std::int32_t last_points = 0, last_bytes = 0;
    for (const auto size : sizes) {
      const Bytes chunk = encode(records.data() + first * record_bytes, size);
      append(bytes, chunk);
      first += size;
      const auto points = static_cast<std::int32_t>(size), length = static_cast<std::int32_t>(chunk.size());
      if (variable) integers.next(table, last_points, points, 0);
      integers.next(table, last_bytes, length, 1);
      last_points = points;
      last_bytes = length;
    }
    put(bytes, points_at, static_cast<std::int64_t>(bytes.size()));
    push(bytes, std::uint32_t{0});
    push(bytes, static_cast<std::uint32_t>(sizes.size()));
    append(bytes, table.finish());
    for (const std::uint32_t threads : {1, 3}) {
      const auto read = read_records(memory_source("a.laz", bytes), all_fields, {.threads = threads});
      ASSERT_EQ(sentence(read), "");
      EXPECT_EQ(read.value().bytes, records);
    }
  }
}

}  // namespace
}  // namespace tessera::testing_io
