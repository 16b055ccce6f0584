#include "src/result/store/duplicate_rows.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "src/base/check.h"
#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/direct_writer.h"

namespace tessera {

namespace fs = std::filesystem;

std::vector<Attribute> carried_schema(const Manifest& manifest) {
  std::vector<Attribute> schema = manifest.schema;
  for (const ResultColumn& column : manifest.columns) {
    if (!column.of_cells) schema.pop_back();
  }
  return schema;
}

Status DuplicateRowSort::push(PointId id, std::span<const std::byte> row) {
  check(row.size() == width_, "a row has the width of all rows");
  ++rows_;
  RowPiece piece{.id = id};
  for (; at(piece.number) < row.size(); ++piece.number) {
    const auto part = row.subspan(at(piece.number), std::min(piece.bytes.size(), row.size() - at(piece.number)));
    piece.bytes = {};
    std::copy(part.begin(), part.end(), piece.bytes.begin());
    BOOST_OUTCOME_TRYV(pieces_.push(piece));
  }
  return success();
}

Result<std::optional<DuplicateRows>> DuplicateRows::open(const fs::path& out, const Manifest& manifest) {
  if (manifest.duplicate_rows_xxh3 == 0) return std::optional<DuplicateRows>{};
  const fs::path path = duplicate_rows_of(out, manifest);
  const auto corrupt = [&](const std::string& why) { return error(Errc::corrupt, path.string() + ": " + why); };
  BOOST_OUTCOME_TRY(sum, checksum_file(path, data_sum_of(manifest.format_version)));
  if (sum != manifest.duplicate_rows_xxh3)
    return corrupt("is damaged: its checksum is " + checksum_text(sum) + ", but the manifest says " +
                   checksum_text(manifest.duplicate_rows_xxh3));
  BOOST_OUTCOME_TRY(file, MappedFile::open(path));
  const std::size_t width = row_bytes(carried_schema(manifest)), bytes = file.bytes().size();
  // Divided, not multiplied, as the number comes from a file and might overflow.
  if (width == 0 || bytes % width != 0 || bytes / width != manifest.duplicates)
    return corrupt("has " + std::to_string(bytes) + " bytes, but must have the attributes of " +
                   std::to_string(manifest.duplicates) + " duplicates, " + std::to_string(width) + " bytes each");
  return std::optional(DuplicateRows(std::move(file), width));
}

namespace store {

Result<std::uint64_t> write_duplicate_rows(const fs::path& out, DuplicateRowSort* rows, std::uint64_t pairs) {
  const fs::path final_name = duplicate_rows_file(out);
  if (rows == nullptr || pairs == 0) {
    BOOST_OUTCOME_TRYV(remove_file(final_name));  // of an earlier result in this folder
    return std::uint64_t{0};
  }
  TemporaryFile temporary(temporary_name(final_name));
  BOOST_OUTCOME_TRY(xxh3, write_rows(temporary.path(), final_name, *rows, pairs));
  BOOST_OUTCOME_TRYV(publish(temporary.path(), final_name));
  temporary.keep();
  return xxh3;
}

Result<std::uint64_t> write_rows(const fs::path& file, const fs::path& final_name, DuplicateRowSort& rows,
                                 std::uint64_t pairs) {
  check(rows.rows() == pairs, "every duplicate has its attributes");
  BOOST_OUTCOME_TRY(writer, DirectWriter::create(file, final_name));
  BOOST_OUTCOME_TRYV(rows.for_each([&](std::span<const std::byte> bytes) { return writer.append(bytes); }));
  BOOST_OUTCOME_TRY(whole, writer.finish());
  return whole.xxh3;
}

}  // namespace store

}  // namespace tessera
