#include "src/result/store/early_cells.h"

#include <fcntl.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "src/base/check.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/tile_layout.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

constexpr std::uint64_t aligned(std::uint64_t bytes) { return (bytes + 4095) / 4096 * 4096; }

constexpr std::uint64_t row_of(int dimension) { return 4 * (static_cast<std::uint64_t>(dimension) + 1); }

Result<TileHeader> header_of(TileId tile, int dimension, const StoreOptions& options) {
  BOOST_OUTCOME_TRY(schema, stored_schema(options.schema));
  return TileHeader{.dimension = dimension,
                    .tile = tile,
                    .points = 0,
                    .cells = 0,
                    .final = false,
                    .neighbors = options.neighbors,
                    .schema = std::move(schema),
                    .offsets = {}};
}

}  // namespace

namespace store {

// Assumes the longest numbers that a header can have.
EarlyOffsets early_offsets(const TileHeader& header, std::uint64_t room) {
  TileHeader longest = header;
  longest.images = true;
  longest.points = longest.cells = std::numeric_limits<std::uint32_t>::max();
  longest.offsets.assign(longest.arrays().size(), std::numeric_limits<std::int64_t>::max());
  const std::uint64_t bytes = room * row_of(header.dimension), table = table_bytes(block_count(bytes));
  EarlyOffsets offsets{};
  offsets.header_bytes = aligned(header_text(longest).size());
  offsets.neighbors = aligned(offsets.header_bytes + table);
  offsets.cells = header.neighbors ? aligned(offsets.neighbors + plain_bytes(bytes) + table) : offsets.neighbors;
  return offsets;
}

Result<EarlyCells> with_room(const fs::path& out, const TileHeader& header, const EarlyCells& early, std::uint64_t room,
                             const StoreOptions& options) {
  const fs::path old = early_file(out, header.tile, early.node), final_name = tile_file(out, header.tile);
  TemporaryFile temporary(temporary_name_of_process(final_name));
  BOOST_OUTCOME_TRY(from, open_handle(old, O_RDONLY));
  BOOST_OUTCOME_TRY(file, DirectWriter::create(temporary.path(), final_name, options.stop));
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  const auto copy = [&](std::uint64_t at, std::uint64_t to) -> Status {
    BOOST_OUTCOME_TRYV(file.skip_to(to));
    for (std::uint64_t left = plain_bytes(early.cells * row_of(header.dimension)); left > 0;) {
      const auto piece = std::span(buffer).first(std::min<std::uint64_t>(left, buffer.size()));
      BOOST_OUTCOME_TRY(read, read_up_to(from.get(), piece, at, old));
      if (read < piece.size()) return error(Errc::corrupt, old.string() + ": is cut off");
      BOOST_OUTCOME_TRYV(file.append(piece));
      at += piece.size();
      left -= piece.size();
    }
    return success();
  };
  const EarlyOffsets before = early_offsets(header, early.room), after = early_offsets(header, room);
  if (header.neighbors) {
    BOOST_OUTCOME_TRYV(copy(before.neighbors, after.neighbors));
  }
  BOOST_OUTCOME_TRYV(copy(before.cells, after.cells));
  EarlyCells moved = early;
  moved.room = room;
  BOOST_OUTCOME_TRY(begun, file.pause());
  moved.begun = std::move(begun);
  BOOST_OUTCOME_TRYV(rename_file(temporary.path(), old));
  temporary.keep();
  return moved;
}

}  // namespace store

Result<EarlyCells> write_early_cells(const fs::path& out, TileId tile, const EarlyInput& input,
                                     const StoreOptions& options) {
  check(input.count % early_unit(input.dimension) == 0 && input.count <= input.room, "early cells are whole blocks");
  BOOST_OUTCOME_TRY(header, header_of(tile, input.dimension, options));
  const fs::path final_name = tile_file(out, tile), path = early_file(out, tile, options.node);
  BOOST_OUTCOME_TRYV(check_held(options.lock_file));
  BOOST_OUTCOME_TRYV(make_directories(path.parent_path()));
  TemporaryFile temporary(path);
  BOOST_OUTCOME_TRY(file, DirectWriter::create(path, final_name, options.stop));
  EarlyCells early{.node = options.node, .cells = input.count, .room = input.room, .digest = {}, .begun = {}};
  const EarlyOffsets offsets = early_offsets(header, input.room);
  const std::uint64_t bytes = input.count * row_of(input.dimension);
  if (header.neighbors) {
    BOOST_OUTCOME_TRYV(file.skip_to(offsets.neighbors));
    BOOST_OUTCOME_TRYV(write_plain(
        bytes,
        [&](const PackedArray::Consumer& take) {
          return input.cells.neighbors([&](std::span<const std::int32_t> piece) { return take(std::as_bytes(piece)); });
        },
        file));
  }
  const CellDigest digest(input.dimension, input.ids);
  BOOST_OUTCOME_TRYV(file.skip_to(offsets.cells));
  BOOST_OUTCOME_TRYV(write_plain(
      bytes,
      [&](const PackedArray::Consumer& take) {
        return input.cells.vertices([&](std::span<const std::int32_t> piece) -> Status {
          BOOST_OUTCOME_TRYV(take(std::as_bytes(piece)));
          early.digest += digest.of(piece);
          return success();
        });
      },
      file));
  BOOST_OUTCOME_TRY(begun, file.pause());
  early.begun = std::move(begun);
  temporary.keep();
  return early;
}

Status take_early_cells(const fs::path& out, TileId tile, EarlyCells& early, const StoreOptions& options) {
  const fs::path there = early_file(out, tile, early.node), here = early_file(out, tile, options.node);
  BOOST_OUTCOME_TRYV(check_held(options.lock_file));
  BOOST_OUTCOME_TRY(bytes, file_bytes(there));
  BOOST_OUTCOME_TRY(sum, checksum_file(there, ChecksumOf::pieces));
  if (bytes != early.begun.bytes || sum != checksum(std::as_bytes(std::span(early.begun.sums))))
    return error(Errc::corrupt, there.string() + ": is damaged: it does not hold the cells that were written early");
  if (there == here) return success();
  BOOST_OUTCOME_TRYV(rename_file(there, here));
  early.node = options.node;
  return success();
}

BigVector<std::byte> bytes_of(const EarlyCells& early) {
  FlatWriter out;
  out.value(early.node);
  out.value(early.cells);
  out.value(early.room);
  out.value(early.digest);
  out.value(early.begun.bytes);
  out.list(early.begun.sums);
  return out.take();
}

std::optional<EarlyCells> early_cells_of(std::span<const std::byte> bytes) {
  EarlyCells early;
  FlatReader in(bytes);
  const bool read = in.value(early.node) && in.value(early.cells) && in.value(early.room) && in.value(early.digest) &&
                    in.value(early.begun.bytes) && in.list(early.begun.sums) && in.at_end();
  if (!read || early.room < early.cells) return std::nullopt;
  return early;
}

}  // namespace tessera
