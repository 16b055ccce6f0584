// Sorts more records than fit into memory: sorted runs in unnamed files are merged at the end.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <queue>
#include <span>
#include <stop_token>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/ledger.h"
#include "src/base/result.h"
#include "src/base/stoppable_sort.h"

namespace tessera {

// Record is trivially copyable and has operator<. After `stop` is requested, the functions soon return the error
// interrupted.
template <class Record>
class ExternalSort {
 public:
  static_assert(std::is_trivially_copyable_v<Record>);

  ExternalSort(std::filesystem::path scratch, std::uint64_t memory_bytes,
               std::stop_token stop = Ledger::token_of_thread())
      : scratch_(std::move(scratch)),
        capacity_(std::max<std::uint64_t>(memory_bytes / sizeof(Record), 1024)),
        stop_(std::move(stop)) {}

  Status push(const Record& record) {
    if (buffer_.size() == buffer_.capacity()) {
      if (buffer_.size() >= capacity_) {
        BOOST_OUTCOME_TRYV(spill());
      } else {
        // Grows by half, not by two: while the buffer moves, old and new memory are both held.
        buffer_.reserve(std::min<std::uint64_t>(capacity_, std::max<std::uint64_t>(1024, buffer_.size() * 3 / 2)));
      }
    }
    buffer_.push_back(record);
    return success();
  }

  // Calls `visit(record)` for all records in order, until `visit` returns an error. The sorter cannot be used
  // afterwards.
  template <class Visit>
  Status for_each(Visit&& visit) {
    if (runs_.empty()) {
      BOOST_OUTCOME_TRYV(sort_buffer());
      for (std::size_t i = 0; i < buffer_.size(); ++i) {
        if (i % records_a_look == 0) {
          BOOST_OUTCOME_TRYV(go_on());
        }
        BOOST_OUTCOME_TRYV(visit(buffer_[i]));
      }
      return success();
    }
    BOOST_OUTCOME_TRYV(spill());
    decltype(buffer_)().swap(buffer_);
    return merge(visit);
  }

  std::size_t runs() const { return runs_.size(); }

 private:
  struct SortedRun {
    FileHandle file;
    std::uint64_t records = 0;
  };

  class Cursor {
   public:
    Cursor(const SortedRun& run, std::size_t records) : run_(&run), buffer_(records) {}
    // Moves to the next record; false at the end of the run.
    Result<bool> next() {
      if (++at_ < filled_) return true;
      const auto wanted = std::min<std::uint64_t>(buffer_.size(), run_->records - done_);
      if (wanted == 0) return false;
      const auto bytes = std::as_writable_bytes(std::span(buffer_.data(), wanted));
      BOOST_OUTCOME_TRY(read, read_up_to(run_->file.get(), bytes, done_ * sizeof(Record), "the scratch file"));
      if (read != bytes.size()) return io_error("the scratch file", "cannot read back", EIO);
      done_ += wanted;
      filled_ = wanted;
      at_ = 0;
      return true;
    }
    const Record& record() const { return buffer_[at_]; }

   private:
    const SortedRun* run_;
    std::vector<Record> buffer_;
    std::uint64_t done_ = 0;
    std::size_t at_ = 0, filled_ = 0;
  };

  static constexpr std::uint64_t records_a_look = 1 << 16;

  Status go_on() const {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while sorting");
    return success();
  }

  Status sort_buffer() {
    try {
      sort_unless_stopped(buffer_.begin(), buffer_.end(), stop_);
    } catch (const Stopped&) {
      return go_on();
    }
    return success();
  }

  Status spill() {
    BOOST_OUTCOME_TRYV(sort_buffer());
    BOOST_OUTCOME_TRY(file, nameless_file(scratch_));
    SortedRun run{std::move(file), buffer_.size()};
    BOOST_OUTCOME_TRYV(write_at(run.file.get(), std::as_bytes(std::span(buffer_)), 0, scratch_));
    runs_.push_back(std::move(run));
    buffer_.clear();
    return success();
  }

  template <class Visit>
  Status merge(Visit& visit) {
    std::vector<Cursor> cursors;
    for (const auto& run : runs_)
      cursors.emplace_back(run, std::max<std::size_t>(256, static_cast<std::size_t>(capacity_ / runs_.size())));
    const auto later = [&](std::size_t a, std::size_t b) { return cursors[b].record() < cursors[a].record(); };
    std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> queue(later);
    for (std::size_t i = 0; i < cursors.size(); ++i) {
      BOOST_OUTCOME_TRY(more, cursors[i].next());
      if (more) queue.push(i);
    }
    for (std::uint64_t visited = 0; !queue.empty(); ++visited) {
      if (visited % records_a_look == 0) {
        BOOST_OUTCOME_TRYV(go_on());
      }
      const std::size_t i = queue.top();
      queue.pop();
      BOOST_OUTCOME_TRYV(visit(cursors[i].record()));
      BOOST_OUTCOME_TRY(more, cursors[i].next());
      if (more) queue.push(i);
    }
    return success();
  }

  std::filesystem::path scratch_;
  std::uint64_t capacity_;
  std::stop_token stop_;
  std::vector<Record> buffer_;
  std::vector<SortedRun> runs_;
};

// Calls `visit(span)` for each group of successive records for which `same(a, b)` holds. A damaged file can make a
// group as large as it likes. So groups are cut at `group_max` records, which is more than any sound result has.
template <class Record, class Same, class Visit>
Status for_each_group(ExternalSort<Record>& sorted, std::size_t group_max, Same same, Visit visit) {
  std::vector<Record> group;
  BOOST_OUTCOME_TRYV(sorted.for_each([&](const Record& record) -> Status {
    if (!group.empty() && (group.size() >= group_max || !same(group.front(), record))) {
      BOOST_OUTCOME_TRYV(visit(std::span<const Record>(group)));
      group.clear();
    }
    group.push_back(record);
    return success();
  }));
  if (group.empty()) return success();
  return visit(std::span<const Record>(group));
}

}  // namespace tessera
