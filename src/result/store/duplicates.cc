#include "src/result/store/duplicates.h"

#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/direct_writer.h"
#include "src/result/store/period.h"

namespace tessera {

namespace fs = std::filesystem;

namespace store {

Result<WrittenPairs> write_duplicates(const fs::path& out, DuplicateSort& pairs) {
  static_assert(sizeof(DuplicatePair) == 16);
  const fs::path final_name = duplicates_file(out);
  TemporaryFile temporary(temporary_name(final_name));
  WrittenPairs written;
  std::optional<DirectWriter> file;
  BOOST_OUTCOME_TRYV(pairs.for_each([&](const DuplicatePair& pair) -> Status {
    if (!file) {
      BOOST_OUTCOME_TRY(opened, DirectWriter::create(temporary.path(), final_name));
      file.emplace(std::move(opened));
    }
    ++written.count;
    return file->append(std::as_bytes(std::span(&pair, 1)));
  }));
  if (!file) {
    BOOST_OUTCOME_TRYV(remove_file(final_name));  // of an earlier result in this folder
    return written;
  }
  BOOST_OUTCOME_TRY(whole, file->finish());
  written.xxh3 = whole.xxh3;
  BOOST_OUTCOME_TRYV(publish(temporary.path(), final_name));
  temporary.keep();
  return written;
}

Result<WrittenPairs> write_pairs(const fs::path& file, const fs::path& final_name,
                                 std::span<const DuplicatePair> pairs) {
  BOOST_OUTCOME_TRY(writer, DirectWriter::create(file, final_name));
  BOOST_OUTCOME_TRYV(writer.append(std::as_bytes(pairs)));
  BOOST_OUTCOME_TRY(whole, writer.finish());
  return WrittenPairs{pairs.size(), whole.xxh3};
}

}  // namespace store

fs::path duplicates_of(const fs::path& out, const Manifest& manifest) {
  return has_lists_of_versions(manifest.format_version) ? duplicates_file(out, manifest.duplicates_xxh3)
                                                        : duplicates_file(out);
}

fs::path duplicate_rows_of(const fs::path& out, const Manifest& manifest) {
  return has_lists_of_versions(manifest.format_version) ? duplicate_rows_file(out, manifest.duplicate_rows_xxh3)
                                                        : duplicate_rows_file(out);
}

Result<std::vector<DuplicatePair>> read_duplicates(const fs::path& out, const Manifest& manifest) {
  const auto path = duplicates_of(out, manifest);
  if (has_lists_of_versions(manifest.format_version) && manifest.duplicates_xxh3 == 0)
    return std::vector<DuplicatePair>{};
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return std::vector<DuplicatePair>{};
  BOOST_OUTCOME_TRY(bytes, read_whole(path));
  return parse_duplicates(path, bytes, manifest.keep);
}

Result<std::vector<DuplicatePair>> parse_duplicates(const fs::path& path, std::span<const std::byte> bytes,
                                                    DuplicatePolicy keep) {
  if (bytes.size() % 16 != 0) return error(Errc::corrupt, path.string() + ": ends in the middle of a pair");
  std::vector<DuplicatePair> pairs(bytes.size() / 16);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    std::memcpy(&pairs[i].duplicate, bytes.data() + 16 * i, 8);
    std::memcpy(&pairs[i].kept, bytes.data() + 16 * i + 8, 8);
    if (i > 0 && pairs[i - 1].duplicate >= pairs[i].duplicate)
      return error(Errc::corrupt, path.string() + ", pair " + std::to_string(i) + ": is not in ascending order");
    const auto refuse = [&](const char* what) {
      return error(Errc::corrupt, path.string() + ", pair " + std::to_string(i) + ": the kept point " + what);
    };
    if (pairs[i].kept == pairs[i].duplicate) return refuse("is its own duplicate");
    if (keep == DuplicatePolicy::first && pairs[i].kept > pairs[i].duplicate)
      return refuse("comes after its duplicate");
    if (keep == DuplicatePolicy::last && pairs[i].kept < pairs[i].duplicate)
      return refuse("comes before its duplicate");
  }
  return pairs;
}

}  // namespace tessera
