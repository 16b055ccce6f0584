#include "src/input/cloud/cloud_sample.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "src/base/ledger.h"
#include "src/base/mixed_bits.h"
#include "src/input/bytes/far_source.h"
#include "src/input/cloud/in_order.h"
#include "src/input/cloud/point_filter.h"

namespace tessera {
namespace {

// The sizes of blocks. 256 LAS records take two or three pages. A smaller block costs the disk as much, and a larger
// block says less, because neighbours in a file are neighbours in space. A large sample decides where many tiles are
// cut; then the number of blocks in a tile counts, and blocks are made as small as disk and decoder permit.
constexpr std::uint64_t block_points = 256, small_block_points = 32, large_sample = 100'000;

std::uint64_t block_points_of(std::uint64_t quota, const FileInfo& file, std::uint64_t points) {
  const bool small = quota > large_sample && quota / small_block_points * file.seek_points < points / 8;
  return small ? small_block_points : block_points;
}

// Shares the sample among the files. A file whose header gives no count may have points, however small it is.
std::uint64_t estimated_points(const FileInfo& file) {
  return file.points ? *file.points : std::max<std::uint64_t>(1, file.about_points());
}

// Keeps points and drops every second one whenever there are twice as many as wanted.
class Thinning {
 public:
  explicit Thinning(std::uint64_t wanted) : wanted_(std::max<std::uint64_t>(1, wanted)) {}

  void add(const Point& p) {
    if (seen_++ % stride_ != 0) return;
    points_.push_back(p);
    if (points_.size() < 2 * wanted_) return;
    for (std::size_t i = 0; i < wanted_; ++i) points_[i] = points_[2 * i];
    points_.resize(wanted_);
    stride_ *= 2;
  }
  const std::vector<Point>& points() const { return points_; }

 private:
  std::uint64_t wanted_, seen_ = 0, stride_ = 1;
  std::vector<Point> points_;
};

// Blocks of `block` points of the `n` points of a file, at random places.
struct Blocks {
  std::uint64_t n = 0, block = 0, blocks = 0;
};

class FileSampler {
 public:
  FileSampler(PointReader& reader, const PointFilter& filter) : reader_(reader), filter_(filter) {}

  // Reads blocks of a reader that can seek, before filtering.
  Status blocks(const Blocks& which, std::uint64_t first, std::uint64_t last, std::vector<Point>& to) {
    const auto& [n, block, blocks] = which;
    for (std::uint64_t b = first; b < last; ++b) {
      // The b-th of `blocks` equal ranges has one block at a random place. n * b may need more than 64 bits.
      const auto begin = part(n, b, blocks), length = part(n, b + 1, blocks) - begin;
      const auto count = std::min(length, block);
      const auto at = begin + mixed_bits(b) % (length - count + 1);
      BOOST_OUTCOME_TRYV(reader_.seek(at));
      std::uint64_t got = 0;
      while (got < count) {
        BOOST_OUTCOME_TRYV(reader_.next(batch_, static_cast<std::size_t>(count - got)));
        if (batch_.points.empty()) break;
        got += batch_.points.size();
        BOOST_OUTCOME_TRYV(keep());
        for (const auto& p : kept_.points) to.push_back(p.at);
      }
    }
    return success();
  }

  // Reads about `wanted` of all points that pass the filter.
  Status whole(std::uint64_t wanted, std::vector<Point>& to) {
    Thinning thinning(wanted);
    while (true) {
      BOOST_OUTCOME_TRYV(reader_.next(batch_));
      if (batch_.points.empty()) break;
      BOOST_OUTCOME_TRYV(keep());
      for (const auto& p : kept_.points) thinning.add(p.at);
    }
    to.insert(to.end(), thinning.points().begin(), thinning.points().end());
    return success();
  }

 private:
  __extension__ using Uint128 = unsigned __int128;
  static std::uint64_t part(std::uint64_t n, std::uint64_t b, std::uint64_t blocks) {
    return static_cast<std::uint64_t>(Uint128{n} * b / blocks);
  }

  Status keep() {
    kept_.points.clear();
    kept_.rows.clear();
    CloudCounts ignored;
    return filter_.apply(batch_, reader_, 0, kept_, ignored);
  }

  PointReader& reader_;
  const PointFilter& filter_;
  PointBatch batch_;
  CloudBatch kept_;
};

// Reads blocks of a file on a server with a reader for each request under way, because a reader waits for its block.
Status sample_far(const Cloud& cloud, std::size_t file, const PointFilter& filter, const Blocks& which,
                  std::vector<Point>& to) {
  constexpr std::uint64_t at_once = 16;
  const std::uint64_t pieces = std::min(at_once, which.blocks);
  const auto read = [&, ledger = Ledger::of_thread()](std::size_t i) -> Result<std::vector<Point>> {
    const Ledger::Use use(ledger);
    std::vector<Point> sample;
    BOOST_OUTCOME_TRY(reader, cloud.reopen(file, filter.reader_schema(), {.threads = 1}));
    FileSampler sampler(*reader, filter);
    BOOST_OUTCOME_TRYV(sampler.blocks(which, i * which.blocks / pieces, (i + 1) * which.blocks / pieces, sample));
    return sample;
  };
  return in_order(static_cast<std::size_t>(pieces), at_once, read,
                  [&](std::size_t, std::vector<Point> sample) -> Status {
                    to.insert(to.end(), sample.begin(), sample.end());
                    return success();
                  });
}

Result<bool> is_far(const Cloud& cloud, std::size_t file) {
  BOOST_OUTCOME_TRY(source, cloud.source(file));
  return near_bytes_max(*source) > 0;
}

}  // namespace

Result<std::vector<Point>> sample_cloud(const Cloud& cloud, std::size_t wanted) {
  const auto& files = cloud.files();
  const std::uint32_t threads = cloud.options().threads;
  const PointFilter filter(cloud.options(), {});
  std::uint64_t total = 0;
  for (const auto& file : files) total += estimated_points(file);
  std::vector<Point> points;
  if (total == 0 || wanted == 0) return points;

  // A filter may leave few points of a sample that was taken before it. Then a larger sample is taken, in the end
  // everything.
  for (double share = static_cast<double>(wanted) / static_cast<double>(total);;) {
    points.clear();
    const auto sample_of = [&](std::size_t i) -> Result<std::vector<Point>> {
      std::vector<Point> sample;
      const FileInfo& file = files[i];
      const auto estimate = estimated_points(file);
      const auto quota = static_cast<std::uint64_t>(std::min(share, 1.0) * static_cast<double>(estimate)) + 1;
      // A single file is read by all threads; several files are read by one thread each.
      BOOST_OUTCOME_TRY(reader, cloud.reopen(i, filter.reader_schema(), {.threads = files.size() == 1 ? threads : 1}));
      FileSampler sampler(*reader, filter);
      BOOST_OUTCOME_TRY(seekable, reader->seek(0));
      // Where each seek decodes points first, reading the whole file once may take less.
      const std::uint64_t block = block_points_of(quota, file, estimate);
      const bool worthwhile = quota / block * file.seek_points < estimate;
      if (seekable && file.points && worthwhile) {
        const std::uint64_t n = *file.points;
        const Blocks which{.n = n, .block = block, .blocks = (std::min(quota, n) + block - 1) / block};
        BOOST_OUTCOME_TRY(far, is_far(cloud, i));
        if (far) {
          BOOST_OUTCOME_TRYV(sample_far(cloud, i, filter, which, sample));
        } else {
          BOOST_OUTCOME_TRYV(sampler.blocks(which, 0, which.blocks, sample));
        }
      } else {
        BOOST_OUTCOME_TRYV(sampler.whole(quota, sample));
      }
      return sample;
    };
    BOOST_OUTCOME_TRYV(
        in_order(files.size(), threads, sample_of, [&](std::size_t, std::vector<Point> sample) -> Status {
          points.insert(points.end(), sample.begin(), sample.end());
          return success();
        }));
    if (share >= 1 || points.size() >= wanted / 2) break;
    share *= points.empty() ? 16 : 1.1 * static_cast<double>(wanted) / static_cast<double>(points.size());
  }
  return points;
}

}  // namespace tessera
