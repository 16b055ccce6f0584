#include "src/tiling/tile_sums.h"

#include <algorithm>
#include <vector>

#include "src/base/option.h"
#include "src/files/checksum.h"
#include "src/files/disk_file.h"

namespace tessera {

Error damaged_run(const std::filesystem::path& path, const std::string& what) {
  return error(Errc::corrupt, path.string() + ": " + what + "; " + option("overwrite", "true") + " starts again");
}

Error wrong_size(const std::filesystem::path& path, std::uint64_t bytes, std::uint64_t records,
                 std::size_t record_bytes) {
  return damaged_run(path, "has " + std::to_string(bytes) + " bytes, but " + std::to_string(records) + " records of " +
                               std::to_string(record_bytes) + " bytes were written");
}

Error wrong_sum(const std::filesystem::path& path, std::uint64_t sum, std::uint64_t written) {
  return damaged_run(
      path, "is damaged: its checksum is " + checksum_text(sum) + ", " + checksum_text(written) + " was written");
}

Status check_records(const std::filesystem::path& path, std::uint64_t records, std::size_t record_bytes,
                     std::uint64_t sum) {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  const std::size_t part = std::max<std::size_t>(1, (std::size_t{1} << 18) / record_bytes);  // fits the cache
  std::vector<std::byte> buffer(part * record_bytes);
  std::uint64_t bytes = 0;
  std::uint64_t found = 0;
  while (true) {
    BOOST_OUTCOME_TRY(n, file.read(buffer));
    const auto whole = std::span(buffer).first(n - n % record_bytes);
    found += record_checksum(whole, record_bytes, bytes / record_bytes);
    bytes += n;
    if (n < buffer.size()) break;
  }
  if (bytes % record_bytes != 0 || bytes / record_bytes != records)
    return wrong_size(path, bytes, records, record_bytes);
  if (found != sum) return wrong_sum(path, found, sum);
  return success();
}

}  // namespace tessera
