// Takes a result through a writer: the main cells, each once, with the vertices they use.
#pragma once

#include <filesystem>
#include <functional>
#include <stop_token>

#include "src/export/formats.h"
#include "src/store/tile_store.h"

namespace tessera::exports {

// What a writer of `format` is told of the whole result. With `heights` the attribute "z" of a 2D result becomes the
// third coordinate.
MeshHead head_of(const Manifest& manifest, const Format& format, bool heights);

struct MeshSource {
  const std::filesystem::path& out;
  const Manifest& manifest;
  const Format& format;
  bool heights = true;
  std::stop_token stop = {};
  std::function<void(double)> progress = {};  // or null
};

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
