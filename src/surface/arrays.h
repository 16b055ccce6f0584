// Arrays of numbers in a scratch file, one after the other, each with its length before it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "src/base/files/disk_file.h"
#include "src/base/files/there.h"
#include "src/base/result.h"

namespace tessera::surface {

// Writes arrays to a file, or reads them back. Not thread-safe.
class Arrays {
 public:
  explicit Arrays(DiskFile file) : file_(std::move(file)) {}
  template <class Array>
  Status put(const Array& array) {
    const std::uint64_t size = array.size();
    BOOST_OUTCOME_TRYV(file_.write(std::as_bytes(std::span(&size, 1))));
    return file_.write(std::as_bytes(std::span(array)));
  }
  // Returns false when the file is too short, or has a length above `most`. Other damage is not noticed.
  template <class Array>
  Result<bool> get(Array& array, std::uint64_t most) {
    std::uint64_t size = 0;
    BOOST_OUTCOME_TRY(head, file_.read(std::as_writable_bytes(std::span(&size, 1))));
    if (head != sizeof size || size > most) return false;
    array.resize(size);
    const auto bytes = std::as_writable_bytes(std::span(array));
    BOOST_OUTCOME_TRY(read, file_.read(bytes));
    return read == bytes.size();
  }
  Status close() { return file_.close(); }

 private:
  DiskFile file_;
};

// save_arrays() writes to a file all arrays that `each` passes to the function it is given. load_arrays() reads them
// back in the same order. Error io.
template <class Each>
Status save_arrays(const std::filesystem::path& path, const Each& each) {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::replace));
  Arrays arrays(std::move(file));
  Status status = success();
  each([&](const auto& array) {
    if (status) status = arrays.put(array);
  });
  BOOST_OUTCOME_TRYV(std::move(status));
  return arrays.close();
}

template <class Each>
Status load_arrays(const std::filesystem::path& path, const Each& each) {
  BOOST_OUTCOME_TRY(bytes, file_bytes(path));
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  Arrays arrays(std::move(file));
  Status status = success();
  each([&](auto& array) {
    if (!status) return;
    auto whole = arrays.get(array, bytes);
    if (!whole) {
      status = std::move(whole).error();
    } else if (!whole.value()) {
      status = error(Errc::io, path.string() + ": is shorter than it was");
    }
  });
  return status;
}

}  // namespace tessera::surface
