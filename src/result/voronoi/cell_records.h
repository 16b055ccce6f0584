// Cells on their way from tiles to the file: scratch keeps them, so that any number of them come out by id.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"

namespace tessera::voronoi {

// What a file has of a cell, beside its shape and the attributes of its point.
struct CellHead {
  std::uint64_t id = 0;  // of the point
  double size = 0;       // the area, or in 3D the volume, of the part that is left; infinite without a limit
  double surface = 0;    // 3D
  double centroid[3] = {};
  std::uint32_t neighbours = 0;
  std::uint32_t unbounded = 0;  // 1: the whole cell is
};

struct CellRecord {
  CellHead head;
  std::span<const std::byte> row;    // the attributes of the point
  std::span<const std::byte> shape;  // as the writer of the file takes it
};

class CellRecords {
 public:
  // The file without a name is made in `scratch`. Error io.
  static Result<std::unique_ptr<CellRecords>> create(const std::filesystem::path& scratch, std::size_t row_bytes,
                                                     std::uint64_t memory_bytes, std::stop_token stop);

  // Adds records of one thread. Call flush() at the end.
  class Adder {
   public:
    explicit Adder(CellRecords& to) : to_(to) {}
    Status add(const CellRecord& record);
    Status flush();

   private:
    friend class CellRecords;
    CellRecords& to_;
    std::vector<std::byte> bytes_;
    std::vector<std::pair<std::uint64_t, std::uint32_t>> sizes_;  // ids, and the bytes of their records
  };

  std::uint64_t count() const { return count_; }
  // Calls visit(record) for all records by ascending id. Errors: those of `visit`; io; interrupted.
  Status for_each(const std::function<Status(const CellRecord&)>& visit);

 private:
  struct Place {
    std::uint64_t id = 0, offset = 0, bytes = 0;
    friend bool operator<(const Place& a, const Place& b) { return a.id < b.id; }
  };
  CellRecords(std::filesystem::path scratch, FileHandle file, std::size_t row_bytes, std::uint64_t memory_bytes,
              std::stop_token stop)
      : scratch_(scratch),
        file_(std::move(file)),
        row_bytes_(row_bytes),
        places_(std::move(scratch), memory_bytes, std::move(stop)) {}

  std::filesystem::path scratch_;
  FileHandle file_;
  std::size_t row_bytes_;
  std::mutex mutex_;
  std::uint64_t end_ = 0, count_ = 0;
  ExternalSort<Place> places_;
};

}  // namespace tessera::voronoi
