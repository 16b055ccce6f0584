// Writes the first cells of a tile file before the other cells are known, so that these cells need no memory.
//
// The two arrays `neighbors` and `connectivity` begin with these cells. Both arrays come before all others, in this
// order, with room for later cells behind each. Room that is not needed stays a hole in the file, which takes no disk
// space.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "src/base/big_vector.h"
#include "src/base/result.h"
#include "src/geometry/mesh/cell_stream.h"
#include "src/result/store/direct_writer.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

// Describes the early cells of a tile.
struct EarlyCells {
  NodeId node;  // the node whose early_file() has the cells
  std::uint64_t cells = 0;
  std::uint64_t room = 0;  // number of cells for which the arrays have room, early cells included
  Digest digest;           // of the early cells
  store::DirectWriter::Begun begun;
};

// The number of cells in a block of either array. The number of early cells is a multiple of it.
constexpr std::uint64_t early_unit(int dimension) { return dimension == 3 ? 4095 : 5460; }

struct EarlyInput {
  int dimension;
  std::span<const PointId> ids;  // of the tile's own vertices, which are the vertices of the cells
  const CellStream& cells;       // main cells
  std::uint64_t count;           // number of cells, a multiple of early_unit()
  std::uint64_t room;            // at least `count`
};
// Writes the early cells of a tile. Replaces early cells that this node has written of the tile before. Error io.
Result<EarlyCells> write_early_cells(const std::filesystem::path& out, TileId tile, const EarlyInput& input,
                                     const StoreOptions& options);
// Takes over the early cells that another node or an earlier process has written. Reads them once to check them; then
// they belong to this node. Errors: io; corrupt when the cells cannot be used.
Status take_early_cells(const std::filesystem::path& out, TileId tile, EarlyCells& early, const StoreOptions& options);
// Converts EarlyCells to bytes and back. Only the program that wrote the bytes may read them. Returns nothing when the
// bytes are damaged.
BigVector<std::byte> bytes_of(const EarlyCells& early);
std::optional<EarlyCells> early_cells_of(std::span<const std::byte> bytes);

namespace store {

// Offsets of the early cells in a file with this header. The header's offsets and counts are ignored.
struct EarlyOffsets {
  std::uint64_t header_bytes;
  std::uint64_t neighbors, cells;  // offset of the first block of each array
};
EarlyOffsets early_offsets(const TileHeader& header, std::uint64_t room);
// Moves the early cells to a file with more room, which replaces the old file. Errors: io, corrupt.
Result<EarlyCells> with_room(const std::filesystem::path& out, const TileHeader& header, const EarlyCells& early,
                             std::uint64_t room, const StoreOptions& options);

}  // namespace store
}  // namespace tessera
