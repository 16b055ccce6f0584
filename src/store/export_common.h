// What the writers of all formats share: buffered output that appears whole or not at all, and vertex numbers.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>
#include <vector>

#include "src/store/export.h"
#include "src/store/files.h"
#include "src/store/tile_store.h"

namespace tessera::store {

// A file under a temporary name, written through one buffer or more.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& target);
  int fd() const { return file_.get(); }
  const std::filesystem::path& target() const { return target_; }
  // Syncs and renames; the size.
  Result<std::uint64_t> finish();

 private:
  OutputFile(std::filesystem::path target, TemporaryFile temporary, FileHandle file)
      : target_(std::move(target)), temporary_(std::move(temporary)), file_(std::move(file)) {}
  std::filesystem::path target_;
  TemporaryFile temporary_;
  FileHandle file_;
};

// Bytes that follow each other from some place of a file on. Errors are kept until flush().
class Stream {
 public:
  Stream(const OutputFile& file, std::uint64_t offset) : fd_(file.fd()), path_(file.target()), offset_(offset) {}
  void text(std::string_view text) { bytes(std::as_bytes(std::span(text.data(), text.size()))); }
  template <class T>
  void value(const T& value) {
    bytes(std::as_bytes(std::span(&value, 1)));
  }
  // The shortest digits that read back as the same number.
  template <class T>
  void digits(T value) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    text({buffer, static_cast<std::size_t>(end - buffer)});
  }
  void bytes(std::span<const std::byte> bytes) {
    if (buffer_.size() + bytes.size() > buffer_bytes) write();
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  std::uint64_t offset() const { return offset_ + buffer_.size(); }
  Status flush();

 private:
  static constexpr std::size_t buffer_bytes = std::size_t{1} << 18;
  void write();
  int fd_;
  std::filesystem::path path_;
  std::uint64_t offset_;
  std::vector<std::byte> buffer_;
  Status status_ = success();
};

// One number per vertex of the result, from 0: own vertices tile by tile. Remembers only those that other tiles use.
class VertexNumbers {
 public:
  // Calls `visit` with each tile's vertices (and rows, when wanted), which are numbered in this order.
  template <class Visit>
  static Result<VertexNumbers> assign(const std::filesystem::path& out, const Manifest& manifest, bool with_rows,
                                      std::stop_token stop, Visit&& visit) {
    VertexNumbers numbers;
    BOOST_OUTCOME_TRYV(numbers.collect_foreign(out, manifest, stop));
    for (const auto& entry : manifest.tiles) {
      if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
      BOOST_OUTCOME_TRY(tile, read_tile_vertices(out, TileId{entry.tile}, with_rows));
      numbers.number_own(tile.mesh);
      BOOST_OUTCOME_TRYV(visit(tile));
    }
    return numbers;
  }
  // The numbers of a tile's vertices. REQUIRES: `index`-th tile of the manifest. Error corrupt: a vertex nobody owns.
  Result<std::vector<std::uint64_t>> of(const TileMesh& mesh, std::size_t index,
                                        const std::filesystem::path& path) const;
  std::uint64_t vertices() const { return next_; }

 private:
  Status collect_foreign(const std::filesystem::path& out, const Manifest& manifest, std::stop_token stop);
  void number_own(const TileMesh& mesh);

  std::vector<std::pair<std::uint64_t, std::uint64_t>> foreign_;  // (id, number), by id
  std::vector<std::uint64_t> first_;                              // by tile: the number of its first own vertex
  std::uint64_t next_ = 0;
};

// Reads the tiles in order and hands each to `visit(tile, index)`.
template <class Visit>
Status for_each_tile(const std::filesystem::path& out, const Manifest& manifest, bool with_rows, std::stop_token stop,
                     Visit&& visit) {
  for (std::size_t i = 0; i < manifest.tiles.size(); ++i) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    BOOST_OUTCOME_TRY(tile, read_tile(out, TileId{manifest.tiles[i].tile}, with_rows));
    if (tile.mesh.dimension != manifest.dimension)
      return error(Errc::corrupt,
                   tile_file(out, TileId{manifest.tiles[i].tile}).string() + ": has another dimension than the result");
    BOOST_OUTCOME_TRYV(visit(tile, i));
  }
  return success();
}

// Error corrupt when what was found is not what the manifest counted: the header is written before the data.
Status check_counts(const std::filesystem::path& out, const Manifest& manifest, const Exported& found);

Result<Exported> export_ply(const std::filesystem::path& out, const Manifest& manifest,
                            const std::filesystem::path& target, std::stop_token stop);
Result<Exported> export_off(const std::filesystem::path& out, const Manifest& manifest,
                            const std::filesystem::path& target, std::stop_token stop);
Result<Exported> export_geojson(const std::filesystem::path& out, const Manifest& manifest,
                                const std::filesystem::path& target, std::stop_token stop);
Result<Exported> export_vtu_file(const std::filesystem::path& out, const Manifest& manifest,
                                 const std::filesystem::path& target, std::stop_token stop);
Result<Exported> export_vtu_folder(const std::filesystem::path& out, const Manifest& manifest,
                                   const std::filesystem::path& target, std::stop_token stop);

// "2154" of "EPSG:2154" or of a WKT text whose horizontal system says so; empty when unknown.
std::string epsg_code(const std::string& crs);

}  // namespace tessera::store
