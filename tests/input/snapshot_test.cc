// Snapshots of simulations, made up and real.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "tests/input/io_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

// Appends numbers, in the byte order that is asked for.
class Writer {
 public:
  explicit Writer(bool swapped) : swapped_(swapped) {}
  template <class T>
  Writer& add(T value) {
    std::array<std::byte, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (swapped_) std::reverse(bytes.begin(), bytes.end());
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  void add(const std::string& text) { append(bytes_of(text)); }
  void append(const Bytes& bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  const Bytes& bytes() const { return bytes_; }

 private:
  bool swapped_;
  Bytes bytes_;
};

struct Made {
  std::array<std::uint32_t, 6> particles{2, 3, 0, 0, 1, 0};
  std::array<std::uint32_t, 6> total{2, 3, 0, 0, 1, 0};
  std::array<double, 6> mass{0, 0.5, 0, 0, 0, 0};
  std::int32_t files = 1;
  double box = 100, time = 0.25;
  bool labels = false, swapped = false, wide = false;
};

// Particle i is at (i, 10 + i, 20 + i); its velocity is -i, its number 1000 + i, its own mass 7 + i.
Bytes gadget(const Made& made) {
  Writer out(made.swapped);
  const auto block = [&](const std::string& label, const Bytes& content) {
    const auto length = static_cast<std::uint32_t>(content.size());
    if (made.labels) {
      out.add(std::uint32_t{8});
      out.add(label);
      out.add(length + 8).add(std::uint32_t{8});
    }
    out.add(length);
    out.append(content);
    out.add(length);
  };
  Writer header(made.swapped);
  for (const auto n : made.particles) header.add(n);
  for (const auto m : made.mass) header.add(m);
  header.add(made.time).add(0.0).add(std::int32_t{0}).add(std::int32_t{0});
  for (const auto n : made.total) header.add(n);
  header.add(std::int32_t{0}).add(made.files).add(made.box);
  header.append(Bytes(256 - header.bytes().size()));
  block("HEAD", header.bytes());
  const auto add_real = [&](Writer& to, double value) {
    if (made.wide) {
      to.add(value);
    } else {
      to.add(static_cast<float>(value));
    }
  };
  std::uint32_t all = 0;
  for (const auto n : made.particles) all += n;
  Writer positions(made.swapped), velocities(made.swapped), ids(made.swapped), masses(made.swapped),
      energy(made.swapped);
  std::uint32_t i = 0;
  for (std::size_t type = 0; type < 6; ++type)
    for (std::uint32_t k = 0; k < made.particles[type]; ++k, ++i) {
      for (int axis = 0; axis < 3; ++axis) add_real(positions, i + 10.0 * axis);
      for (int axis = 0; axis < 3; ++axis) add_real(velocities, -static_cast<double>(i));
      if (made.wide) {
        ids.add(std::uint64_t{1000} + i);
      } else {
        ids.add(std::uint32_t{1000} + i);
      }
      if (made.mass[type] == 0) add_real(masses, 7.0 + i);
      if (type == 0) add_real(energy, 50.0 + i);
    }
  block("POS ", positions.bytes());
  block("VEL ", velocities.bytes());
  block("ID  ", ids.bytes());
  if (!masses.bytes().empty()) block("MASS", masses.bytes());
  if (made.labels) block("ZZZZ", Bytes(36));
  if (!energy.bytes().empty()) block("U   ", energy.bytes());
  return out.bytes();
}

const std::vector<Attribute> some{{"particle_type", AttributeType::u8},
                                  {"vx", AttributeType::f64},
                                  {"particle_id", AttributeType::u64},
                                  {"mass", AttributeType::f64},
                                  {"internal_energy", AttributeType::f32}};

TEST(Gadget, IsReadInBothFormatsByteOrdersAndWidths) {
  for (const bool labels : {false, true})
    for (const bool swapped : {false, true})
      for (const bool wide : {false, true}) {
        SCOPED_TRACE(testing::Message() << labels << swapped << wide);
        const auto read = read_bytes(gadget({.labels = labels, .swapped = swapped, .wide = wide}), "snap", some);
        ASSERT_EQ(sentence(read), "");
        ASSERT_EQ(read.value().points.size(), 6u);
        EXPECT_EQ(read.value().info.format, "gadget");
        EXPECT_EQ(read.value().info.points, 6u);
        EXPECT_EQ(read.value().info.box, (Point{100, 100, 100}));
        const std::array<int, 6> types{0, 0, 1, 1, 1, 4};
        for (std::size_t i = 0; i < 6; ++i) {
          const auto n = static_cast<double>(i);
          EXPECT_EQ(read.value().points[i], (Point{n, n + 10, n + 20}));
          EXPECT_EQ(cell<std::uint8_t>(read.value(), some, i, 0), types[i]);
          EXPECT_EQ(cell<double>(read.value(), some, i, 1), -n);
          EXPECT_EQ(cell<std::uint64_t>(read.value(), some, i, 2), 1000 + i);
          EXPECT_EQ(cell<double>(read.value(), some, i, 3), types[i] == 1 ? 0.5 : n + 7);
          const auto energy = cell<float>(read.value(), some, i, 4);
          EXPECT_TRUE(types[i] == 0 ? energy == static_cast<float>(n) + 50 : std::isnan(energy));
        }
      }
}

// Bytes of which some must not be read once `opened` is true: the first bytes of all files tell their format.
class Untouched : public ByteSource {
 public:
  Untouched(Bytes bytes, std::uint64_t begin, std::uint64_t end, const bool& opened)
      : bytes_(memory_source("snap", std::move(bytes))), begin_(begin), end_(end), opened_(opened) {}
  const std::filesystem::path& path() const override { return bytes_->path(); }
  std::uint64_t size() const override { return bytes_->size(); }
  std::int64_t modified_ns() const override { return 0; }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (opened_ && offset < end_ && offset + out.size() > begin_)
      return error(Errc::io, "snap: what is not wanted was read");
    return bytes_->read(offset, out);
  }
  Status check_unchanged() const override { return success(); }

 private:
  std::unique_ptr<ByteSource> bytes_;
  std::uint64_t begin_, end_;
  const bool& opened_;
};

TEST(Gadget, ParticlesOfOtherTypesAreSkippedUnread) {
  for (const bool labels : {false, true}) {
    SCOPED_TRACE(labels);
    const Bytes bytes = gadget({.labels = labels});
    // The positions of the dark matter, particles 2 to 4, behind header, labels and lengths.
    const std::uint64_t at = 264 + (labels ? 2 * 16 : 0) + 4 + 2 * 12;
    bool is_open = false;
    auto opened = open_reader(std::make_unique<Untouched>(bytes, at, at + 36, is_open), some, {.particles = {0, 4}});
    ASSERT_EQ(sentence(opened), "");
    is_open = true;
    PointReader& reader = *opened.value();
    EXPECT_EQ(reader.info().points, 3u);
    EXPECT_EQ(reader.info().points_passed_over, 3u);
    ASSERT_EQ(reader.info().particles.size(), 3u);
    EXPECT_EQ(reader.info().particles[1].count, 3u);
    EXPECT_EQ(reader.info().particles[1].mass, 0.5);
    PointBatch batch;
    ASSERT_TRUE(reader.next(batch));
    EXPECT_EQ(batch.points, (std::vector<Point>{{0, 10, 20}, {1, 11, 21}}));
    EXPECT_EQ(batch.passed_over, 0u);
    ASSERT_TRUE(reader.next(batch));
    EXPECT_EQ(batch.points, (std::vector<Point>{{5, 15, 25}}));
    EXPECT_EQ(batch.passed_over, 3u);
    EXPECT_EQ(reader.place(0), "particle 5");
    ASSERT_TRUE(reader.next(batch));
    EXPECT_TRUE(batch.points.empty());
    ASSERT_TRUE(reader.seek(2));
    ASSERT_TRUE(reader.next(batch));
    EXPECT_EQ(batch.points, (std::vector<Point>{{5, 15, 25}}));
  }
  const auto dark = read_bytes(gadget({}), "snap", {}, {.particles = {1}});
  ASSERT_EQ(sentence(dark), "");
  EXPECT_EQ(dark.value().points, (std::vector<Point>{{2, 12, 22}, {3, 13, 23}, {4, 14, 24}}));
  for (const Attribute& attribute : dark.value().info.attributes) EXPECT_NE(attribute.name, "internal_energy");
}

TEST(Gadget, WhatIsCutOffOrDamagedIsRefused) {
  for (const bool labels : {false, true}) {
    const Bytes whole = gadget({.labels = labels});
    for (std::size_t size = 300; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const auto read = read_bytes(cut, "snap");
      // What ends between two blocks behind the positions is whole as far as anyone can tell.
      if (read.has_value()) {
        EXPECT_EQ(read.value().points.size(), 6u);
      } else {
        EXPECT_NE(sentence(read).find("snap"), std::string::npos);
      }
    }
  }
  Bytes other = gadget({});
  put<std::uint32_t>(other, 4, 9);  // more gas than the blocks have
  EXPECT_NE(sentence(read_bytes(other, "snap")).find("the block 'POS ' has 72 bytes, but 13 particles take 156 or 312"),
            std::string::npos)
      << sentence(read_bytes(other, "snap"));
  put<std::uint32_t>(other, 4, 0xFFFFFFFF);
  EXPECT_NE(sentence(read_bytes(other, "snap")), "");
  Bytes nan = gadget({});
  put<double>(nan, 4 + 128, std::nan(""));
  EXPECT_EQ(sentence(read_bytes(nan, "snap")), "snap: says that its box is not a length of 0 or more");
}

// Files of snapshots in a folder.
class Snapshots : public testing::Test {
 protected:
  std::string write(const std::string& name, Made made, std::uint32_t gas) {
    made.particles = {gas, 0, 0, 0, 0, 0};
    made.total = {6, 0, 0, 0, 0, 0};
    return folder_.write(name, gadget(made)).string();
  }
  std::string refusal(const std::vector<std::string>& files) {
    std::string text = sentence(Cloud::open(files, {}));
    for (std::size_t at = 0; (at = text.find(folder_.path().string() + "/")) != std::string::npos;)
      text.erase(at, folder_.path().string().size() + 1);
    return text;
  }
  TempFolder folder_;
};

TEST_F(Snapshots, OfSeveralFilesAreOneCloudWithAllItsFiles) {
  const Made of_three{.files = 3};
  const auto a = write("snap.0", of_three, 1), b = write("snap.1", of_three, 2), c = write("snap.2", of_three, 3);
  EXPECT_EQ(refusal({a, b, c}), "");
  EXPECT_EQ(refusal({a, c}), "snap.0: is one of 3 files of a snapshot, but 2 are given; snap.1 is missing");
  EXPECT_EQ(refusal({c}), "snap.2: is one of 3 files of a snapshot, but 1 is given; snap.0 is missing");
  EXPECT_EQ(refusal({a, b, c, c}), "snap.2: is given twice");
  write("snap.1", {.files = 3, .time = 0.5}, 2);
  EXPECT_EQ(refusal({a, b, c}),
            "snap.1: is of another snapshot than snap.0: their headers differ in the time, the box, the masses or the "
            "numbers of particles");
  write("snap.1", of_three, 1);
  EXPECT_EQ(refusal({a, b, c}), "snap.0: says that its snapshot has 6 particles, but its files have 5");
  write("snap.1", of_three, 2);
  // Two snapshots are two clouds in one.
  const auto d = write("other.0", {.files = 2, .time = 0.5}, 4), e = write("other.1", {.files = 2, .time = 0.5}, 2);
  EXPECT_EQ(refusal({d, a, b, e, c}), "");
}

TEST_F(Snapshots, FilesOfASetMayHaveNoneOfTheParticles) {
  const Made of_three{.files = 3};
  const auto a = write("snap.0", of_three, 2), b = write("snap.1", of_three, 4), c = write("snap.2", of_three, 0);
  EXPECT_EQ(refusal({a, b, c}), "");
  const auto alone = folder_.write("alone", gadget({.particles = {}, .total = {}})).string();
  EXPECT_EQ(refusal({alone}), "alone: holds no particles");
}

TEST_F(Snapshots, TypesThatNoFileHasAreRefusedWithThoseThatThereAre) {
  const auto whole = folder_.write("whole", gadget({})).string();
  EXPECT_EQ(sentence(Cloud::open({whole}, {.particles = {0, 5}})),
            "particles: the input has no particles of type 5 (black-holes), but 2 of type 0 (gas), 3 of type 1 "
            "(dark-matter), 1 of type 4 (stars)");
  const auto text = folder_.write("a.csv", "x,y,z\n1,2,3\n").string();
  EXPECT_EQ(sentence(Cloud::open({text}, {.particles = {0}})),
            text + ": has no attribute 'particle_type', so particles cannot choose points by it");
  const auto cloud = Cloud::open({whole, whole}, {.particles = {4}});
  ASSERT_EQ(sentence(cloud), "");
  std::vector<std::uint64_t> ids;
  const auto counts = cloud.value().for_each_batch([&](CloudBatch& batch) {
    for (const auto& p : batch.points) ids.push_back(p.id.value);
    return success();
  });
  ASSERT_EQ(sentence(counts), "");
  EXPECT_EQ(ids, (std::vector<std::uint64_t>{5, 11}));  // ranks in the whole input, as without the filter
  EXPECT_EQ(counts.value().read, 12u);
  EXPECT_EQ(counts.value().filtered, 10u);
}

// The same particles in Tipsy: two of gas, three of dark matter, one star.
Bytes tipsy(bool swapped, bool padded) {
  Writer out(swapped);
  out.add(0.25);
  for (const std::int32_t n : {6, 3, 2, 3, 1}) out.add(n);
  if (padded) out.add(std::int32_t{0});
  const std::array<std::size_t, 6> more{5, 5, 2, 2, 2, 4};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto n = static_cast<float>(i);
    out.add(n + 7).add(n).add(n + 10).add(n + 20).add(-n).add(-n).add(-n);
    for (std::size_t k = 0; k < more[i]; ++k) out.add(n * 100 + static_cast<float>(k));
  }
  return out.bytes();
}

TEST(Tipsy, IsReadInBothByteOrders) {
  const std::vector<Attribute> schema{{"particle_type", AttributeType::u8}, {"mass", AttributeType::f32},
                                      {"temperature", AttributeType::f32},  {"softening", AttributeType::f32},
                                      {"potential", AttributeType::f64},    {"vz", AttributeType::f32}};
  for (const bool swapped : {false, true})
    for (const bool padded : {false, true}) {
      const auto read = read_bytes(tipsy(swapped, padded), "disk", schema);
      ASSERT_EQ(sentence(read), "");
      ASSERT_EQ(read.value().points.size(), 6u);
      EXPECT_EQ(read.value().info.format, "tipsy");
      const std::array<int, 6> types{0, 0, 1, 1, 1, 4}, potential{4, 4, 1, 1, 1, 3};
      for (std::size_t i = 0; i < 6; ++i) {
        const auto n = static_cast<float>(i);
        EXPECT_EQ(read.value().points[i], (Point{n, n + 10, n + 20}));
        EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, i, 0), types[i]);
        EXPECT_EQ(cell<float>(read.value(), schema, i, 1), n + 7);
        const auto temperature = cell<float>(read.value(), schema, i, 2),
                   softening = cell<float>(read.value(), schema, i, 3);
        EXPECT_TRUE(types[i] == 0 ? temperature == n * 100 + 1 : std::isnan(temperature));
        EXPECT_TRUE(types[i] == 0 ? std::isnan(softening) : softening == n * 100 + (types[i] == 1 ? 0 : 2));
        EXPECT_EQ(cell<double>(read.value(), schema, i, 4), n * 100 + static_cast<float>(potential[i]));
        EXPECT_EQ(cell<float>(read.value(), schema, i, 5), -n);
      }
    }
}

TEST(Tipsy, ParticlesOfTheTypesThatAreNamedAreRead) {
  const auto read = read_bytes(tipsy(false, true), "disk", {}, {.particles = {1}});
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, (std::vector<Point>{{2, 12, 22}, {3, 13, 23}, {4, 14, 24}}));
  EXPECT_EQ(read.value().info.points, 3u);
  EXPECT_EQ(read.value().info.points_passed_over, 3u);
  EXPECT_EQ(read.value().info.particles.size(), 3u);
}

TEST(Tipsy, OfAnotherLengthThanItsHeaderSaysIsNone) {
  Bytes bytes = tipsy(false, true);
  bytes.pop_back();
  EXPECT_NE(sentence(read_bytes(bytes, "disk")).find("disk: unknown format"), std::string::npos);
  EXPECT_EQ(sentence(read_bytes(bytes, "disk.tipsy")), "disk.tipsy: is no Tipsy snapshot");
}

// Real snapshots, where they are, against the doubles that another program took out of them.
class RealSnapshot : public testing::TestWithParam<RealCloud> {};

TEST_P(RealSnapshot, HasThePositionsThatAnotherProgramReads) {
  const auto read = read_path(GetParam().path());
  ASSERT_EQ(sentence(read), "");
  std::ifstream in(GetParam().path().replace_extension(".bin"), std::ios::binary);
  std::vector<Point> expected(read.value().points.size());
  in.read(reinterpret_cast<char*>(expected.data()), static_cast<std::streamsize>(expected.size() * sizeof(Point)));
  ASSERT_TRUE(in.good() && in.peek() == EOF);
  EXPECT_EQ(read.value().points, expected);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(RealSnapshot);
INSTANTIATE_TEST_SUITE_P(Files, RealSnapshot,
                         testing::ValuesIn(real_clouds({}, {"lcdm_gas.gadget", "galaxy_20k.tipsy"})));

}  // namespace
}  // namespace tessera::testing_io
