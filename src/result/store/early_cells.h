// The first cells of a tile file, written before the others are known, so that nobody has to keep them.
//
// Two arrays begin with them, `neighbors` and `connectivity`. They stand in front of all others, in this order, with
// room for cells that come later in between: what of it is not needed stays a hole, which no disk stores.
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

// What is written down of them.
struct EarlyCells {
  NodeId node;  // whose early_file() they are in
  std::uint64_t cells = 0;
  std::uint64_t room = 0;  // for as many cells, these included
  Digest digest;           // theirs
  store::DirectWriter::Begun begun;
};

// Blocks of both arrays hold so many cells. Early ones are a multiple.
constexpr std::uint64_t early_unit(int dimension) { return dimension == 3 ? 4095 : 5460; }

struct EarlyInput {
  int dimension;
  std::span<const PointId> ids;  // of the tile's own vertices: those of the cells
  const CellStream& cells;       // main ones
  std::uint64_t count;           // of them: a multiple of early_unit()
  std::uint64_t room;            // at least `count`
};
// Replaces what this node has written early of the tile before. Error io.
Result<EarlyCells> write_early_cells(const std::filesystem::path& out, TileId tile, const EarlyInput& input,
                                     const StoreOptions& options);
// As what another node, or an earlier process, has written they are read once, and are this node's from then on.
// Error io, corrupt: they cannot be gone on with.
Status take_early_cells(const std::filesystem::path& out, TileId tile, EarlyCells& early, const StoreOptions& options);
// To be put down by this program, and read back by it: nothing when they are not what it wrote.
BigVector<std::byte> bytes_of(const EarlyCells& early);
std::optional<EarlyCells> early_cells_of(std::span<const std::byte> bytes);

namespace store {

// Where they stand in a file with this header, whose offsets and numbers do not count.
struct EarlyPlaces {
  std::uint64_t header_bytes;
  std::uint64_t neighbors, cells;  // the first block of each array
};
EarlyPlaces early_places(const TileHeader& header, std::uint64_t room);
// The same cells in a file with room for more, in place of the other. Error io, corrupt.
Result<EarlyCells> with_room(const std::filesystem::path& out, const TileHeader& header, const EarlyCells& early,
                             std::uint64_t room, const StoreOptions& options);

}  // namespace store
}  // namespace tessera
