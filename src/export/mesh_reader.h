// Takes a result through a writer: the main cells, each once, with the vertices they use.
#pragma once

#include <filesystem>
#include <stop_token>

#include "src/export/export.h"
#include "src/export/formats.h"
#include "src/store/tile_store.h"

namespace tessera::exports {

struct MeshSource {
  const std::filesystem::path& out;
  const Manifest& manifest;
  const Format& format;
  const ExportOptions& options;
  std::stop_token stop = {};
};

// What a writer of the whole result is told.
MeshHead head_of(const MeshSource& source);

// All tiles to one writer, whose head is head_of(): own vertices tile by tile, then the cells. Reads the tiles up to
// three times. Errors: those of reading; corrupt when the tiles do not hold what the manifest counts; those of the
// writer.
Status read_merged(const MeshSource& source, MeshWriter& writer);

struct TilePiece {
  std::uint64_t own_vertices = 0, cells = 0, bytes = 0;
};
// One tile to a file of its own: its main cells and the vertices they use, numbered from 0. `done`: how many vertices
// and cells all calls together have written, for the progress.
Result<TilePiece> write_piece(const MeshSource& source, std::size_t index, const std::filesystem::path& path,
                              std::uint64_t& done);

}  // namespace tessera::exports
