// Takes a result through a writer: the cells that are exported, each once, with the vertices they use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "src/result/export/mesh_source.h"
#include "src/result/export/selection.h"

namespace tessera::exports {

// That coordinates count from: options.local.
std::optional<Point> corner_of(const MeshSource& source);

// What a writer of the whole selection is told.
MeshHead head_of(const MeshSource& source, const Selection& selection);

// Whether the format is given a list of vertices.
bool lists_vertices(const MeshSource& source);

// All tiles to one writer, whose head is head_of(): own vertices tile by tile, then the cells. Errors: those of
// reading; corrupt when the tiles do not hold what the manifest counts; those of the writer.
Status read_merged(const MeshSource& source, Selection& selection, MeshWriter& writer);

// Cells in memory to one writer; see export_cells().
Status write_cells(const MeshSource& source, const Selection& selection, StoredTile& cells,
                   std::span<const TileId> tiles, MeshWriter& writer);

// The manifest's `index`-th tile to a file of its own: its cells and the vertices they use, numbered from 0. Its bytes.
// `done`: how many vertices and cells all calls together have written, for the progress.
Result<std::uint64_t> write_piece(const MeshSource& source, const Selection& selection, std::size_t index,
                                  const std::filesystem::path& path, std::uint64_t& done);

}  // namespace tessera::exports
