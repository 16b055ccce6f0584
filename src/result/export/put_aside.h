// Numbers that come before their place in the file. They are kept in an unnamed file beside it.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/result/export/output.h"

namespace tessera::exports {

class PutAside {
 public:
  static Result<PutAside> create(const std::filesystem::path& target) {
    BOOST_OUTCOME_TRY(file, nameless_file(folder_of(target)));
    return PutAside(target, std::move(file));
  }
  void add(double number) { stream_.value(number); }
  const Status& status() const { return stream_.status(); }
  // Calls `visit(number)` for each number, in order.
  template <class Visit>
  Status for_each(Visit visit) {
    BOOST_OUTCOME_TRYV(flush());
    constexpr std::uint64_t at_once = 1 << 15;
    std::vector<double> numbers(at_once);
    const std::uint64_t end = stream_.offset();
    for (std::uint64_t at = 0; at < end;) {
      const auto wanted =
          std::as_writable_bytes(std::span(numbers)).first(std::min(end - at, at_once * sizeof(double)));
      BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), wanted, at, target_));
      if (read != wanted.size()) return io_error(target_, "cannot read back a temporary part of the file", EIO);
      for (const double number : std::span(numbers).first(read / sizeof(double))) visit(number);
      at += read;
    }
    return success();
  }

  // Makes the numbers that were added so far readable.
  Status flush() { return stream_.flush(); }
  // Returns the `index`-th number. REQUIRES: flush() was called since it was added.
  Result<double> at(std::uint64_t index) const {
    double number = 0;
    const auto bytes = std::as_writable_bytes(std::span(&number, 1));
    BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), bytes, index * sizeof number, target_));
    if (read != bytes.size()) return io_error(target_, "cannot read back a temporary part of the file", EIO);
    return number;
  }

 private:
  PutAside(std::filesystem::path target, FileHandle file)
      : target_(std::move(target)), file_(std::move(file)), stream_(file_.get(), target_, 0) {}
  std::filesystem::path target_;
  FileHandle file_;
  Stream stream_;
};

}  // namespace tessera::exports
