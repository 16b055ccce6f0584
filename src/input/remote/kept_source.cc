#include "src/input/remote/kept_source.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <new>
#include <string>
#include <unordered_set>
#include <utility>

namespace tessera::remote {
namespace {

// Ranges that are nearer together than that are one request: at 10 MB/s, 64 KiB take less time than a round trip.
constexpr std::uint64_t gap_bytes_max = std::uint64_t{16} << 10;
constexpr std::uint64_t request_bytes_max = std::uint64_t{1} << 20;
constexpr std::uint64_t requests_at_once = 32;  // twice those in flight, so that no connection waits
// What is fetched for a read that follows no other: a few small reads around one place are one request.
constexpr std::uint64_t first_ahead_bytes = std::uint64_t{16} << 10, ahead_bytes_max = std::uint64_t{16} << 20;

constexpr std::uint64_t page_of(std::uint64_t offset) { return offset / page_bytes; }
constexpr std::uint64_t page_after(std::uint64_t end) { return (end + page_bytes - 1) / page_bytes; }

class KeptSource : public FarSource {
 public:
  KeptSource(std::unique_ptr<RangeReader> object, std::shared_ptr<KeptPages> pages, OpenBeside beside)
      : object_(std::move(object)),
        path_(object_->name()),
        pages_(std::move(pages)),
        beside_(std::move(beside)),
        number_(next_number.fetch_add(1)),
        near_bytes_(pages_->bytes_max() / 4) {}  // a quarter: several threads may bring at once

  const std::filesystem::path& path() const override { return path_; }
  std::uint64_t size() const override { return object_->size(); }
  std::int64_t modified_ns() const override { return object_->modified_ns(); }
  Status check_unchanged() const override { return object_->check_unchanged(); }
  std::uint64_t near_bytes_max() const override { return near_bytes_; }
  Result<std::shared_ptr<const ByteSource>> open_beside(const std::string& name,
                                                        std::size_t first_bytes) const override {
    return beside_(name, first_bytes);
  }
  std::shared_ptr<const Learnt> learnt() const override {
    const std::lock_guard lock(mutex_);
    return learnt_;
  }
  void learn(std::shared_ptr<const Learnt> what) const override {
    const std::lock_guard lock(mutex_);
    learnt_ = std::move(what);
  }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > size() || out.size() > size() - offset)
      return error(Errc::bad_input, path_.string() + ": became shorter while it was read");
    std::uint64_t done = 0;
    while (done < out.size()) {  // in pieces that surely are kept until they are copied
      const auto n = std::min<std::uint64_t>(near_bytes_, out.size() - done);
      BOOST_OUTCOME_TRYV(read_piece(offset + done, out.subspan(done, static_cast<std::size_t>(n))));
      done += n;
    }
    return success();
  }

  Status bring(std::span<const ByteRange> ranges) const override {
    std::vector<ByteRange> sorted(ranges.begin(), ranges.end());
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
    std::vector<ByteRange> wanted;
    std::uint64_t next = 0;  // the page behind those that were looked at
    std::unique_lock lock(mutex_);
    for (const auto& range : sorted) {
      auto page = page_of(range.begin);
      const bool near = next > 0 && (page <= next || (page - next) * page_bytes <= gap_bytes_max);
      if (near) page = next;
      for (; page < page_after(range.end); ++page) add_missing(page, wanted);
      next = std::max(next, page);
    }
    lock.unlock();
    return fetch(std::move(wanted));
  }

  Status put_begin(std::vector<std::byte> bytes) {
    for (std::uint64_t page = 0; page * page_bytes < bytes.size(); ++page) {
      const auto whole = page_end(page) - page * page_bytes;
      const auto there = std::span<const std::byte>(bytes).subspan(static_cast<std::size_t>(page * page_bytes));
      if (there.size() < whole) break;
      BOOST_OUTCOME_TRYV(pages_->put({number_, page}, there.first(static_cast<std::size_t>(whole))));
    }
    return success();
  }

 private:
  std::uint64_t page_end(std::uint64_t page) const { return std::min((page + 1) * page_bytes, size()); }

  // Marks a page as under way, and adds its bytes to the last range or as a new one, unless the page is here or under
  // way. REQUIRES: the mutex is held.
  void add_missing(std::uint64_t page, std::vector<ByteRange>& wanted) const {
    if (pages_->has({number_, page}) || !under_way_.insert(page).second) return;
    if (!wanted.empty() && wanted.back().end == page * page_bytes)
      wanted.back().end = page_end(page);
    else
      wanted.push_back({page * page_bytes, page_end(page)});
  }

  Status read_piece(std::uint64_t offset, std::span<std::byte> out) const {
    const std::uint64_t first = page_of(offset), last = page_after(offset + out.size());
    std::unique_lock lock(mutex_);
    while (true) {
      std::vector<ByteRange> wanted;
      bool waits = false;
      for (auto page = first; page < last; ++page) {
        waits = waits || under_way_.contains(page);
        add_missing(page, wanted);
      }
      if (wanted.empty() && !waits) {
        BOOST_OUTCOME_TRY(whole, copy(offset, out));
        if (whole) return success();
        continue;  // other threads have pushed out some of the pages
      }
      if (wanted.empty()) {
        arrived_.wait(lock);
        continue;
      }
      look_ahead(first, last, wanted);
      lock.unlock();
      BOOST_OUTCOME_TRYV(fetch(std::move(wanted)));
      lock.lock();
    }
  }

  // Adds pages behind those that are read. REQUIRES: the mutex is held.
  void look_ahead(std::uint64_t first, std::uint64_t last, std::vector<ByteRange>& wanted) const {
    const bool goes_on = first <= ahead_end_ && last > ahead_end_ && ahead_end_ > 0;
    ahead_bytes_ = goes_on ? std::min({2 * ahead_bytes_, ahead_bytes_max, near_bytes_}) : first_ahead_bytes;
    const auto end = std::min(page_after(size()), std::max(last, first + ahead_bytes_ / page_bytes));
    for (auto page = last; page < end; ++page) add_missing(page, wanted);
    ahead_end_ = end;
  }

  // Returns false when a page is not here any more.
  Result<bool> copy(std::uint64_t offset, std::span<std::byte> out) const {
    while (!out.empty()) {
      const auto page = page_of(offset), begin = offset % page_bytes;
      const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(page_bytes - begin, out.size()));
      BOOST_OUTCOME_TRY(here, pages_->read({number_, page}, begin, out.first(n)));
      if (!here) return false;
      offset += n;
      out = out.subspan(n);
    }
    return true;
  }

  // Fetches ranges of pages that are marked as under way, and unmarks them, also on error.
  Status fetch(std::vector<ByteRange> ranges) const {
    std::vector<ByteRange> requests;
    for (const auto& range : ranges)
      for (auto begin = range.begin; begin < range.end; begin += request_bytes_max)
        requests.push_back({begin, std::min(range.end, begin + request_bytes_max)});
    std::size_t done = 0;
    Status status = success();
    while (done < requests.size() && status.has_value()) {
      const auto n = std::min<std::size_t>(requests_at_once, requests.size() - done);
      status = fetch_at_once(std::span<const ByteRange>(requests).subspan(done, n));
      done += n;
    }
    if (status.has_value()) return status;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& request : std::span<const ByteRange>(requests).subspan(done)) unmark(request);
    }
    arrived_.notify_all();
    return status;
  }

  void unmark(const ByteRange& range) const {
    for (auto page = page_of(range.begin); page < page_after(range.end); ++page) under_way_.erase(page);
  }

  Status fetch_at_once(std::span<const ByteRange> requests) const {
    auto got = ask_for(requests);
    Status status = success();
    {
      const std::lock_guard lock(mutex_);
      if (got.has_error()) status = got.error();
      for (std::size_t i = 0; i < requests.size(); ++i) {
        if (status.has_value()) status = put(requests[i], got.value()[i]);
        unmark(requests[i]);
      }
    }
    arrived_.notify_all();
    return status;
  }

  // An exception would leave the pages marked for ever.
  Result<std::vector<std::vector<std::byte>>> ask_for(std::span<const ByteRange> requests) const try {
    return object_->read(requests);
  } catch (const std::bad_alloc&) {
    return worded([this] { return error(Errc::memory, path_.string() + ": no memory is left to fetch it"); });
  }

  // REQUIRES: the mutex is held.
  Status put(const ByteRange& range, std::span<const std::byte> bytes) const {
    for (auto page = page_of(range.begin); page < page_after(range.end); ++page) {
      const auto at = page * page_bytes;
      BOOST_OUTCOME_TRYV(pages_->put({number_, page}, bytes.subspan(static_cast<std::size_t>(at - range.begin),
                                                                    static_cast<std::size_t>(page_end(page) - at))));
    }
    return success();
  }

  std::unique_ptr<RangeReader> object_;
  std::filesystem::path path_;
  mutable std::mutex mutex_;
  mutable std::condition_variable arrived_;
  std::shared_ptr<KeptPages> pages_;
  OpenBeside beside_;
  mutable std::shared_ptr<const Learnt> learnt_;
  inline static std::atomic<std::uint64_t> next_number{0};
  std::uint64_t number_;  // of the object, among all of the process
  mutable std::unordered_set<std::uint64_t> under_way_;
  mutable std::uint64_t ahead_end_ = 0, ahead_bytes_ = 0;  // the page behind the last one that was fetched ahead
  std::uint64_t near_bytes_;
};

}  // namespace

Result<std::unique_ptr<FarSource>> keep_source(std::unique_ptr<RangeReader> object, std::vector<std::byte> begin,
                                               std::shared_ptr<KeptPages> pages, OpenBeside beside) {
  auto source = std::make_unique<KeptSource>(std::move(object), std::move(pages), std::move(beside));
  BOOST_OUTCOME_TRYV(source->put_begin(std::move(begin)));
  return std::unique_ptr<FarSource>(std::move(source));
}

}  // namespace tessera::remote
