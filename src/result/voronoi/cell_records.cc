#include "src/result/voronoi/cell_records.h"

#include <cerrno>
#include <cstring>

namespace tessera::voronoi {

namespace fs = std::filesystem;

Result<std::unique_ptr<CellRecords>> CellRecords::create(const fs::path& scratch, std::size_t row_bytes,
                                                         std::uint64_t memory_bytes, std::stop_token stop) {
  BOOST_OUTCOME_TRY(file, nameless_file(scratch));
  return std::unique_ptr<CellRecords>(
      new CellRecords(scratch, std::move(file), row_bytes, memory_bytes, std::move(stop)));
}

Status CellRecords::Adder::add(const CellRecord& record) {
  constexpr std::size_t buffered = std::size_t{1} << 20;
  const auto head = std::as_bytes(std::span(&record.head, 1));
  const std::size_t before = bytes_.size();
  bytes_.insert(bytes_.end(), head.begin(), head.end());
  bytes_.insert(bytes_.end(), record.row.begin(), record.row.end());
  bytes_.insert(bytes_.end(), record.shape.begin(), record.shape.end());
  sizes_.emplace_back(record.head.id, static_cast<std::uint32_t>(bytes_.size() - before));
  return bytes_.size() < buffered ? Status(success()) : flush();
}

Status CellRecords::Adder::flush() {
  std::uint64_t offset = 0;
  {
    const std::lock_guard lock(to_.mutex_);
    offset = to_.end_;
    to_.end_ += bytes_.size();
    to_.count_ += sizes_.size();
    std::uint64_t at = offset;
    for (const auto& [id, bytes] : sizes_) {
      BOOST_OUTCOME_TRYV(to_.places_.push({id, at, bytes}));
      at += bytes;
    }
  }
  BOOST_OUTCOME_TRYV(write_at(to_.file_.get(), bytes_, offset, to_.scratch_));
  bytes_.clear();
  sizes_.clear();
  return success();
}

Status CellRecords::for_each(const std::function<Status(const CellRecord&)>& visit) {
  std::vector<std::byte> bytes;
  return places_.for_each([&](const Place& place) -> Status {
    bytes.resize(place.bytes);
    BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), bytes, place.offset, "the scratch file"));
    if (read != bytes.size()) return io_error("the scratch file", "cannot read back", EIO);
    CellRecord record;
    std::memcpy(&record.head, bytes.data(), sizeof record.head);
    record.row = std::span<const std::byte>(bytes).subspan(sizeof record.head, row_bytes_);
    record.shape = std::span<const std::byte>(bytes).subspan(sizeof record.head + row_bytes_);
    return visit(record);
  });
}

}  // namespace tessera::voronoi
