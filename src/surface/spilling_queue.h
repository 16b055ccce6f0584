// Records of one kind on their way between tiles: in memory, and on disk if there are too many.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/files/disk_file.h"
#include "src/base/files/surface_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/result.h"

namespace tessera::surface {

// A queue of records for each tile. Thread-safe.
template <class Record>
class SpillingQueue {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  // `folder`: used by this object alone. `memory_bytes`: records beyond that wait in the folder.
  SpillingQueue(std::filesystem::path folder, std::size_t tiles, std::uint64_t memory_bytes)
      : folder_(std::move(folder)), boxes_(tiles), memory_records_(memory_bytes / sizeof(Record)) {}

  Status send(std::size_t to, std::span<const Record> records) {
    if (records.empty()) return success();
    Box& box = boxes_[to];
    const std::lock_guard lock(box.mutex);
    sent_ += records.size();
    box.waiting += records.size();
    box.records.insert(box.records.end(), records.begin(), records.end());
    if ((held_ += records.size()) <= memory_records_) return success();
    BOOST_OUTCOME_TRY(file, DiskFile::open(path(to), DiskFile::Mode::append));
    BOOST_OUTCOME_TRYV(file.write(std::as_bytes(std::span(box.records))));
    BOOST_OUTCOME_TRYV(file.close());
    held_ -= box.records.size();
    box.on_disk += box.records.size();
    box.records = {};
    return success();
  }

  // Returns all records that wait for a tile, in no particular order.
  Result<std::vector<Record>> take(std::size_t to) {
    Box& box = boxes_[to];
    const std::lock_guard lock(box.mutex);
    std::vector<Record> records = std::exchange(box.records, {});
    held_ -= records.size();
    if (box.on_disk > 0) {
      const std::size_t begin = records.size();
      records.resize(begin + box.on_disk);
      BOOST_OUTCOME_TRY(file, DiskFile::open(path(to), DiskFile::Mode::read));
      const auto wanted = std::as_writable_bytes(std::span(records).subspan(begin));
      BOOST_OUTCOME_TRY(read, file.read(wanted));
      if (read != wanted.size()) return error(Errc::io, path(to).string() + ": is shorter than it was");
      BOOST_OUTCOME_TRYV(remove_file(path(to)));
    }
    box.on_disk = box.waiting = 0;
    return records;
  }

  bool any(std::size_t to) const { return boxes_[to].waiting > 0; }
  std::uint64_t sent() const { return sent_; }  // records since the beginning

 private:
  struct Box {
    std::mutex mutex;
    std::vector<Record> records;
    std::uint64_t on_disk = 0;
    std::atomic<std::uint64_t> waiting{0};
  };
  std::filesystem::path path(std::size_t to) const { return surface_mail_file(folder_, to); }

  std::filesystem::path folder_;
  std::vector<Box> boxes_;
  std::uint64_t memory_records_;
  std::atomic<std::uint64_t> held_{0}, sent_{0};
};

// Collects records by tile before they are sent. Not thread-safe.
template <class Record>
class SendBuffer {
 public:
  SendBuffer(SpillingQueue<Record>& queue, std::size_t tiles) : queue_(queue), records_(tiles) {}
  Status add(std::size_t to, const Record& record) {
    auto& records = records_[to];
    records.push_back(record);
    if (records.size() < most) return success();
    BOOST_OUTCOME_TRYV(queue_.send(to, records));
    records.clear();
    return success();
  }
  Status send() {
    for (std::size_t to = 0; to < records_.size(); ++to) {
      BOOST_OUTCOME_TRYV(queue_.send(to, records_[to]));
      records_[to].clear();
    }
    return success();
  }

 private:
  static constexpr std::size_t most = 4096;
  SpillingQueue<Record>& queue_;
  std::vector<std::vector<Record>> records_;
};

}  // namespace tessera::surface
