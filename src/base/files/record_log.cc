#include "src/base/files/record_log.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/whole_file.h"

namespace tessera {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "logs are little endian and written without conversion");

namespace {

constexpr std::uint32_t magic = 0x764c7354;  // "TsLv"

struct Header {
  std::uint32_t magic = 0, kind = 0;
  std::uint64_t length = 0, number = 0, sum = 0;
};
static_assert(sizeof(Header) == 32);

std::uint64_t sum_of(const Header& header) {
  return checksum(std::as_bytes(std::span(&header, 1)).first(sizeof header - sizeof header.sum));
}

constexpr std::uint64_t around = sizeof(Header) + sizeof(std::uint64_t);  // bytes of a record beside its payload

// So many zeros at the end of a file tell that the disk had not written a record to its end. Smaller than a sector.
constexpr std::uint64_t unwritten = 256;

}  // namespace

Result<RecordLog> RecordLog::open(const fs::path& path, const Visit& visit) {
  BOOST_OUTCOME_TRY(file, open_handle(path, O_RDWR | O_CREAT));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return io_error(path, "cannot lock", errno);
    return error(Errc::usage, path.string() + ": another process has this log; only one process may change a result");
  }
  RecordLog log(path, std::move(file));
  BOOST_OUTCOME_TRYV(log.read(visit));
  BOOST_OUTCOME_TRYV(sync_folder(path.parent_path()));
  return log;
}

Error RecordLog::damaged(const std::string& what) const {
  return error(Errc::corrupt, path_.string() + ", byte " + std::to_string(end_) + ": " + what);
}

Result<bool> RecordLog::zeros_from(std::uint64_t at, std::uint64_t size) const {
  std::array<std::byte, 1 << 16> buffer;
  for (; at < size;) {
    BOOST_OUTCOME_TRY(n, read_up_to(file_.get(), buffer, at, path_));
    if (n == 0) break;
    if (std::any_of(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n),
                    [](std::byte b) { return b != std::byte{0}; }))
      return false;
    at += n;
  }
  return true;
}

Status RecordLog::read(const Visit& visit) {
  BOOST_OUTCOME_TRY(size, size_of(file_, path_));
  while (end_ < size) {
    Header header;
    const std::uint64_t left = size - end_;
    const auto bytes =
        std::as_writable_bytes(std::span(&header, 1)).first(std::min<std::uint64_t>(left, sizeof header));
    BOOST_OUTCOME_TRY(got, read_up_to(file_.get(), bytes, end_, path_));
    if (got < sizeof header) break;
    if (header.magic != magic || header.sum != sum_of(header)) {
      BOOST_OUTCOME_TRY(zeros, zeros_from(end_, size));
      if (zeros) break;
      return damaged("no record begins here, so the log is damaged");
    }
    if (header.number != next_)
      return damaged("record " + std::to_string(header.number) + " stands where record " + std::to_string(next_) +
                     " should be, so the log is damaged");
    if (left < around || header.length > left - around) break;  // not written to its end
    std::vector<std::byte> payload(header.length + sizeof(std::uint64_t));
    BOOST_OUTCOME_TRY(n, read_up_to(file_.get(), payload, end_ + sizeof header, path_));
    if (n != payload.size()) return damaged("the log became shorter while it was read");
    std::uint64_t sum = 0;
    std::memcpy(&sum, payload.data() + header.length, sizeof sum);
    payload.resize(header.length);
    if (sum != checksum(payload, header.sum)) {
      const std::uint64_t end = end_ + around + header.length;
      BOOST_OUTCOME_TRY(zeros, zeros_from(end - std::min(unwritten, header.length + sizeof sum), size));
      if (zeros && end == size) break;
      return damaged("the record is not the one that was written, so the log is damaged");
    }
    BOOST_OUTCOME_TRYV(visit(header.kind, payload));
    end_ += around + header.length;
    ++next_;
  }
  if (end_ < size && !cut_off()) return io_error(path_, "cannot cut off its incomplete end", errno);
  return success();
}

// What is behind the last whole record.
bool RecordLog::cut_off() const {
  return ::ftruncate(file_.get(), static_cast<off_t>(end_)) == 0 && ::fdatasync(file_.get()) == 0;
}

Status RecordLog::append(std::uint32_t kind, std::span<const std::byte> payload) {
  Header header{magic, kind, payload.size(), next_, 0};
  header.sum = sum_of(header);
  const std::uint64_t sum = checksum(payload, header.sum);
  std::vector<std::byte> record(around + payload.size());
  std::memcpy(record.data(), &header, sizeof header);
  if (!payload.empty()) std::memcpy(record.data() + sizeof header, payload.data(), payload.size());
  std::memcpy(record.data() + sizeof header + payload.size(), &sum, sizeof sum);
  if (const Status written = write_at(file_.get(), record, end_, path_); !written) {
    intact_ = cut_off();
    return written;
  }
  if (::fdatasync(file_.get()) != 0) {
    intact_ = false;
    return io_error(path_, "cannot write", errno);
  }
  end_ += record.size();
  ++next_;
  return success();
}

}  // namespace tessera
