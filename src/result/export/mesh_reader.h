// Passes a result to a writer: each exported cell once, with the vertices that cells use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "src/result/export/mesh_source.h"
#include "src/result/export/selection.h"

namespace tessera::exports {

// The origin of the coordinates for options.local.
std::optional<Point> corner_of(const MeshSource& source);

// The head for a writer of the whole selection.
MeshHead head_of(const MeshSource& source, const Selection& selection);

// Returns true if the format gets a list of vertices.
bool lists_vertices(const MeshSource& source);

// Passes all tiles to one writer with the head head_of(): first the own vertices tile by tile, then the cells. Errors:
// those of reading; corrupt when the tiles do not hold what the manifest counts; those of the writer.
Status read_merged(const MeshSource& source, Selection& selection, MeshWriter& writer);

// Passes cells in memory to one writer; see export_cells().
Status write_cells(const MeshSource& source, const Selection& selection, StoredTile& cells,
                   std::span<const TileId> tiles, MeshWriter& writer);

// Writes the manifest's `index`-th tile to a file of its own: its cells, and the vertices that they use, numbered from
// 0. Returns the bytes of the file. Adds to `done` the vertices and cells that were written, for the progress.
Result<std::uint64_t> write_piece(const MeshSource& source, const Selection& selection, std::size_t index,
                                  const std::filesystem::path& path, std::uint64_t& done);

}  // namespace tessera::exports
