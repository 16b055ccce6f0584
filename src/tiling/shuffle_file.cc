#include "src/tiling/shuffle_file.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/option.h"

namespace tessera {
namespace {

constexpr std::size_t chunk_points = 32768;

// Reads records of one size from a part of a file, and computes their checksum meanwhile.
class Records {
 public:
  static Result<Records> open(const std::filesystem::path& path, std::size_t record_bytes, const Segment& segment) {
    BOOST_OUTCOME_TRY(file, open_handle(path, O_RDONLY));
    return Records(path, std::move(file), record_bytes, segment.begin);
  }

  Status read(std::span<std::byte> to) {
    BOOST_OUTCOME_TRY(got, read_up_to(file_.get(), to, next_ * record_bytes_, path_));
    if (got != to.size())
      return damaged_run(path_, "ends before record " + std::to_string(next_ + to.size() / record_bytes_));
    sum_ += record_checksum(to, record_bytes_, next_);
    next_ += to.size() / record_bytes_;
    return success();
  }

  Status check(std::uint64_t written) const {
    if (sum_ == written) return success();
    return damaged_run(path_, "is damaged before record " + std::to_string(next_) + ": the checksum is " +
                                  checksum_text(sum_) + ", but " + checksum_text(written) + " was written");
  }

 private:
  Records(std::filesystem::path path, FileHandle file, std::size_t record_bytes, std::uint64_t first)
      : path_(std::move(path)), file_(std::move(file)), record_bytes_(record_bytes), next_(first) {}

  std::filesystem::path path_;
  FileHandle file_;
  std::size_t record_bytes_;
  std::uint64_t next_, sum_ = 0;
};

std::filesystem::path points_path(const ShuffleFiles& files, const Segment& segment) {
  return points_file(files.run_folder, files.bundles[segment.bundle].id);
}

std::filesystem::path rows_path(const ShuffleFiles& files, const Segment& segment) {
  return attributes_file(files.run_folder, files.bundles[segment.bundle].id);
}

void add_to_ids(std::span<LocalPoint> points, std::uint64_t first) {
  for (LocalPoint& p : points) p.id.value += first;
}

}  // namespace

Status give_back(const ShuffleFiles& files, std::span<const Segment> segments) {
  const auto punch = [](const std::filesystem::path& path, std::uint64_t begin, std::uint64_t bytes) -> Status {
    BOOST_OUTCOME_TRY(file, open_handle(path, O_RDWR));
    if (::fallocate(file.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(begin),
                    static_cast<off_t>(bytes)) == 0 ||
        errno == EOPNOTSUPP || errno == ENOSYS)
      return success();
    return io_error(path, "cannot give back its disk", errno);
  };
  for (const Segment& segment : segments) {
    BOOST_OUTCOME_TRYV(
        punch(points_path(files, segment), segment.begin * sizeof(LocalPoint), segment.count * sizeof(LocalPoint)));
    if (files.row_bytes == 0) continue;
    BOOST_OUTCOME_TRYV(
        punch(rows_path(files, segment), segment.begin * files.row_bytes, segment.count * files.row_bytes));
  }
  return success();
}

Status for_each_record(const ShuffleFiles& files, std::span<const Segment> segments, const std::stop_token& stop,
                       const VisitRecords& visit) {
  std::vector<LocalPoint> points(chunk_points);
  std::vector<std::byte> rows(chunk_points * files.row_bytes);
  for (const Segment& segment : segments) {
    BOOST_OUTCOME_TRY(from, Records::open(points_path(files, segment), sizeof(LocalPoint), segment));
    // The file of rows is opened only if there are rows. Result has no empty state, so else the file of points takes
    // its place.
    BOOST_OUTCOME_TRY(rows_from, files.row_bytes > 0
                                     ? Records::open(rows_path(files, segment), files.row_bytes, segment)
                                     : Records::open(points_path(files, segment), sizeof(LocalPoint), segment));
    for (std::size_t done = 0; done < segment.count;) {
      if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while tiles were split");
      const std::size_t n = std::min<std::size_t>(chunk_points, segment.count - done);
      const auto chunk = std::span(points).first(n);
      const auto chunk_rows = std::span(rows).first(n * files.row_bytes);
      BOOST_OUTCOME_TRYV(from.read(std::as_writable_bytes(chunk)));
      if (!chunk_rows.empty()) {
        BOOST_OUTCOME_TRYV(rows_from.read(chunk_rows));
      }
      add_to_ids(chunk, files.bundles[segment.bundle].first_id);
      done += n;
      BOOST_OUTCOME_TRYV(visit(chunk, chunk_rows));
    }
    BOOST_OUTCOME_TRYV(from.check(segment.points_sum));
    if (files.row_bytes > 0) {
      BOOST_OUTCOME_TRYV(rows_from.check(segment.rows_sum));
    }
  }
  return success();
}

Status read_points(const ShuffleFiles& files, const Segment& segment, std::span<LocalPoint> to) {
  BOOST_OUTCOME_TRY(from, Records::open(points_path(files, segment), sizeof(LocalPoint), segment));
  BOOST_OUTCOME_TRYV(from.read(std::as_writable_bytes(to)));
  BOOST_OUTCOME_TRYV(from.check(segment.points_sum));
  add_to_ids(to, files.bundles[segment.bundle].first_id);
  return success();
}

Status check_rows(const ShuffleFiles& files, const Segment& segment) {
  BOOST_OUTCOME_TRY(from, Records::open(rows_path(files, segment), files.row_bytes, segment));
  const std::size_t most = std::max<std::size_t>(1, (std::size_t{1} << 18) / files.row_bytes);  // fits the cache
  std::vector<std::byte> rows(std::min<std::size_t>(most, segment.count) * files.row_bytes);
  for (std::size_t done = 0; done < segment.count;) {
    const std::size_t n = std::min<std::size_t>(most, segment.count - done);
    BOOST_OUTCOME_TRYV(from.read(std::span(rows).first(n * files.row_bytes)));
    done += n;
  }
  return from.check(segment.rows_sum);
}

Error damaged_run(const std::filesystem::path& path, const std::string& what) {
  return error(Errc::corrupt, path.string() + ": " + what + "; " + option("overwrite", "true") + " starts again");
}

}  // namespace tessera
