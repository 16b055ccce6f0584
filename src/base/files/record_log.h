// A file to which records are appended, and that is read from its beginning when a process starts again. A record that
// append() has returned for is there after the end of the process, and after a power cut.
//
//   file   = record*
//   record = magic   u32  "TsLv"
//            kind    u32  for the caller
//            length  u64  bytes of the payload
//            number  u64  0 for the first record, then one more for each
//            header  u64  XXH3-64 of the 24 bytes before
//            payload      `length` bytes
//            sum     u64  XXH3-64 of the payload, seeded with `header`
//
// Numbers are little endian. A process that ends while it appends leaves a part of a record at the end of the file.
// This part is cut off, since append() has not returned for it. After a power cut the part may end in zeros instead.
// All else that is wrong is damage: a record before the last one, a header that is neither whole nor zeros, a number
// that is not the next.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

// Not thread-safe.
class RecordLog {
 public:
  using Visit = std::function<Status(std::uint32_t kind, std::span<const std::byte> payload)>;
  // Makes the file if there is none; its folder must exist. Calls `visit` with the records in order, then cuts off what
  // is left of a record that was not written to its end. Errors: usage when another process has the log; corrupt, with
  // the place; io; those of `visit`.
  static Result<RecordLog> open(const std::filesystem::path& path, const Visit& visit);

  // Appends a record and syncs the file. After an error, as of a full disk, the record is not there while the log is
  // intact. Otherwise the record is there or not, and the log can only be destroyed.
  Status append(std::uint32_t kind, std::span<const std::byte> payload);
  bool intact() const { return intact_; }
  std::uint64_t records() const { return next_; }
  std::uint64_t bytes() const { return end_; }

 private:
  RecordLog(std::filesystem::path path, FileHandle file) : path_(std::move(path)), file_(std::move(file)) {}
  Status read(const Visit& visit);
  bool cut_off() const;
  Error damaged(const std::string& what) const;
  Result<bool> zeros_from(std::uint64_t at, std::uint64_t size) const;

  std::filesystem::path path_;
  FileHandle file_;
  std::uint64_t next_ = 0;  // the number of the next record
  std::uint64_t end_ = 0;   // where it goes
  bool intact_ = true;
};

}  // namespace tessera
