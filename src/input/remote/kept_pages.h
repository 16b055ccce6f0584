// Pages of far objects that were fetched, in one file on disk that is bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera::remote {

inline constexpr std::uint64_t page_bytes = 4096;

// A page of one of the objects of a process.
struct PageKey {
  std::uint64_t object = 0, page = 0;
  friend bool operator==(const PageKey&, const PageKey&) = default;
};

// The file has no name, and is made when there is something to keep. When it is full, pages are given up in the order
// in which they came. Thread-safe. Errors: those of making, writing and reading the file; those of the thread's ledger.
class KeptPages {
 public:
  // `folder`: empty for the system's temporary folder. `bytes_max`: raised to 64 MiB if it is less, so that several
  // threads do not push out each other's pages before they are read.
  KeptPages(std::filesystem::path folder, std::uint64_t bytes_max);

  std::uint64_t bytes_max() const { return slots_max_ * page_bytes; }
  bool has(const PageKey& key) const;
  // Reads bytes of a page from `begin` on. Returns false if the page is not here. REQUIRES: begin + out.size() is at
  // most the size of the page that was put.
  Result<bool> read(const PageKey& key, std::uint64_t begin, std::span<std::byte> out) const;
  // REQUIRES: at most page_bytes bytes.
  Status put(const PageKey& key, std::span<const std::byte> bytes);

 private:
  struct Hash {
    std::size_t operator()(const PageKey& key) const;
  };
  std::filesystem::path folder_;
  std::uint64_t slots_max_;
  mutable std::mutex mutex_;
  FileHandle file_;
  std::vector<PageKey> keys_;  // by slot; fewer than slots_max_ until the file is full
  std::unordered_map<PageKey, std::uint64_t, Hash> slots_;
  std::uint64_t next_ = 0;  // the slot that is filled next
};

}  // namespace tessera::remote
