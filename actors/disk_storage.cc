#include "actors/disk_storage.h"

#include <boost/asio/post.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

Error failed(const std::filesystem::path& path, const char* what) {
  return error(Errc::io, path.string() + ": cannot " + what + ": " + std::strerror(errno));
}

}  // namespace

DiskStorage::DiskStorage(const RoutedRun& run, std::filesystem::path out, StoreOptions options, std::uint32_t threads)
    : run_(run), out_(std::move(out)), options_(std::move(options)), writers_(threads) {}

DiskStorage::~DiskStorage() { writers_.join(); }

std::filesystem::path DiskStorage::scratch_file(TileId tile, Scratch what) const {
  constexpr const char* folders[] = {"state", "finals", "mail"};
  char name[32];
  std::snprintf(name, sizeof name, "%06u.bin", tile.value);
  return run_.folder / folders[static_cast<int>(what)] / name;
}

Result<LoadedTile> DiskStorage::load_points(TileId tile) { return load_tile(run_, tile); }

Status DiskStorage::put(TileId tile, Scratch what, std::span<const std::byte> bytes, bool append) {
  const auto path = scratch_file(tile, what);
  std::error_code ignored;  // an existing folder is fine; a missing one shows when the file is opened
  std::filesystem::create_directories(path.parent_path(), ignored);
  File file(std::fopen(path.c_str(), append ? "ab" : "wb"));
  if (!file) return failed(path, "open it for writing");
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) return failed(path, "write");
  if (std::fclose(file.release()) != 0) return failed(path, "write");
  return success();
}

Result<std::vector<std::byte>> DiskStorage::take(TileId tile, Scratch what) {
  const auto path = scratch_file(tile, what);
  std::error_code missing;
  const auto size = std::filesystem::file_size(path, missing);
  if (missing == std::errc::no_such_file_or_directory) return std::vector<std::byte>{};
  File file(std::fopen(path.c_str(), "rb"));
  if (missing || !file) return failed(path, "open it");
  std::vector<std::byte> bytes(size);
  if (std::fread(bytes.data(), 1, size, file.get()) != size) return failed(path, "read");
  if (std::remove(path.c_str()) != 0) return failed(path, "remove");
  return bytes;
}

// Foreign vertices' rows stand in their owners' files.
Result<std::vector<std::byte>> DiskStorage::gather_rows(const TileMesh& mesh) const {
  const std::size_t width = row_bytes(run_.schema);
  std::vector<std::byte> rows(mesh.points.size() * width);
  if (width == 0) return rows;
  std::map<std::uint32_t, std::vector<std::size_t>> by_owner;
  for (std::size_t i = 0; i < mesh.owners.size(); ++i) by_owner[mesh.owners[i]].push_back(i);
  for (const auto& [owner, places] : by_owner) {
    std::vector<std::uint64_t> ids;
    ids.reserve(places.size());
    for (const std::size_t i : places) ids.push_back(mesh.ids[i]);
    BOOST_OUTCOME_TRY(part, load_rows(run_, TileId{owner}, ids));
    for (std::size_t k = 0; k < places.size(); ++k) {
      std::memcpy(&rows[places[k] * width], &part[k * width], width);
    }
  }
  return rows;
}

Result<TileEntry> DiskStorage::write(TileId tile, const TileMesh& mesh) const {
  try {
    BOOST_OUTCOME_TRY(rows, gather_rows(mesh));
    return write_tile(out_, tile, mesh, rows, options_);
  } catch (const std::bad_alloc&) {
    return error(Errc::memory, "out of memory while storing tile " + std::to_string(tile.value) +
                                   ": use smaller tiles or a smaller --memory");
  } catch (const std::exception& e) {
    return error(Errc::internal, "tile " + std::to_string(tile.value) + " cannot be stored: " + e.what());
  }
}

void DiskStorage::store(TileId tile, TileMesh mesh, Stored done) {
  boost::asio::post(writers_, [this, tile, mesh = std::move(mesh), done = std::move(done)]() mutable {
    const Result<TileEntry> entry = write(tile, mesh);
    mesh = {};  // before the node believes that it is gone
    done(entry);
  });
}

}  // namespace tessera
