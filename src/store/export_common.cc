#include "src/store/export_common.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

namespace tessera::store {

namespace fs = std::filesystem;

Result<OutputFile> OutputFile::create(const fs::path& target) {
  TemporaryFile temporary(temporary_name(target));
  FileHandle file(::open(temporary.path().c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) {
    const int number = errno;
    temporary.keep();  // not ours
    return io_error(target, "cannot create", number);
  }
  return OutputFile(target, std::move(temporary), std::move(file));
}

Result<std::uint64_t> OutputFile::finish() {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) return io_error(target_, "cannot write", errno);
  if (!file_.close()) return io_error(target_, "cannot write", errno);
  BOOST_OUTCOME_TRYV(publish(temporary_.path(), target_));
  temporary_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(target_.parent_path()));
  return static_cast<std::uint64_t>(status.st_size);
}

void Stream::write() {
  if (status_) status_ = write_at(fd_, buffer_, offset_, path_);
  offset_ += buffer_.size();
  buffer_.clear();
}

Status Stream::flush() {
  write();
  return status_;
}

Status VertexNumbers::collect_foreign(const fs::path& out, const Manifest& manifest, std::stop_token stop) {
  for (const auto& entry : manifest.tiles) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    BOOST_OUTCOME_TRY(tile, read_tile_vertices(out, TileId{entry.tile}));
    for (std::size_t i = 0; i < tile.mesh.ids.size(); ++i)
      if (tile.mesh.point_ghost[i] != 0) foreign_.emplace_back(tile.mesh.ids[i], ~std::uint64_t{0});
    std::sort(foreign_.begin(), foreign_.end());
    foreign_.erase(std::unique(foreign_.begin(), foreign_.end()), foreign_.end());
  }
  return success();
}

void VertexNumbers::number_own(const TileMesh& mesh) {
  first_.push_back(next_);
  for (std::size_t i = 0; i < mesh.ids.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    const auto found = std::lower_bound(foreign_.begin(), foreign_.end(), std::pair(mesh.ids[i], std::uint64_t{0}));
    if (found != foreign_.end() && found->first == mesh.ids[i]) found->second = next_;
    ++next_;
  }
}

Result<std::vector<std::uint64_t>> VertexNumbers::of(const TileMesh& mesh, std::size_t index,
                                                     const fs::path& path) const {
  std::vector<std::uint64_t> numbers(mesh.ids.size());
  std::uint64_t own = first_[index];
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (mesh.point_ghost[i] == 0) {
      numbers[i] = own++;
      continue;
    }
    const auto found = std::lower_bound(foreign_.begin(), foreign_.end(), std::pair(mesh.ids[i], std::uint64_t{0}));
    if (found == foreign_.end() || found->first != mesh.ids[i] || found->second == ~std::uint64_t{0})
      return error(Errc::corrupt,
                   path.string() + ": foreign vertex " + std::to_string(mesh.ids[i]) + " is no tile's own vertex");
    numbers[i] = found->second;
  }
  return numbers;
}

Status check_counts(const fs::path& out, const Manifest& manifest, const Exported& found) {
  if (found.vertices == manifest.vertices && found.cells == manifest.cells) return success();
  return error(Errc::corrupt, out.string() + ": the tiles hold " + std::to_string(found.vertices) + " vertices and " +
                                  std::to_string(found.cells) + " cells, the manifest counts " +
                                  std::to_string(manifest.vertices) + " and " + std::to_string(manifest.cells));
}

}  // namespace tessera::store
