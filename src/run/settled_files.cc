#include "src/run/settled_files.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/frame.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"

namespace tessera {

SettledFiles::SettledFiles(const std::filesystem::path& run, NodeId node)
    : folder_(scratch_folder(run, ScratchKind::settled)), own_(settled_file(run, node)) {}

Status SettledFiles::append(TileId tile, std::span<const std::byte> bytes) {
  const std::uint64_t name = tile.value;
  std::vector<std::byte> payload(sizeof name + bytes.size());
  std::memcpy(payload.data(), &name, sizeof name);
  if (!bytes.empty()) std::memcpy(payload.data() + sizeof name, bytes.data(), bytes.size());
  const std::lock_guard lock(mutex_);  // a write that is cut short goes on at the end of the file
  index_.reset();
  BOOST_OUTCOME_TRYV(make_directories(folder_));
  return append_frame(own_, ScratchKind::settled, payload);
}

Result<std::optional<SettledFiles::Place>> SettledFiles::find(TileId tile) {
  const std::lock_guard lock(mutex_);
  if (!index_) {
    std::unordered_map<TileId, Place> index;
    FolderReader reader(folder_);
    while (const char* file = reader.next()) {
      if (!is_settled_name(file)) continue;
      BOOST_OUTCOME_TRY(places, places_of_frames(folder_ / file, ScratchKind::settled));
      for (const FramePlace& place : places)
        index[TileId{static_cast<std::uint32_t>(place.name)}] = {folder_ / file, place.at};
    }
    if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
      return io_error(folder_, "cannot be read", reader.error().value());
    index_ = std::move(index);
  }
  const auto found = index_->find(tile);
  return found == index_->end() ? std::optional<Place>() : found->second;
}

Result<bool> SettledFiles::has(TileId tile) {
  BOOST_OUTCOME_TRY(place, find(tile));
  return place.has_value();
}

Result<std::optional<std::vector<std::byte>>> SettledFiles::read(TileId tile) {
  BOOST_OUTCOME_TRY(place, find(tile));
  if (!place) return std::optional<std::vector<std::byte>>();
  BOOST_OUTCOME_TRY(payload, read_frame_at(place->file, ScratchKind::settled, place->at));
  std::uint64_t name = ~std::uint64_t{0};
  if (payload.size() >= sizeof name) std::memcpy(&name, payload.data(), sizeof name);
  if (name != tile.value) {
    return error(Errc::corrupt, place->file.string() + ", byte " + std::to_string(place->at) + ": is not what tile " +
                                    std::to_string(tile.value) + " has written");
  }
  payload.erase(payload.begin(), payload.begin() + sizeof name);
  return std::optional(std::move(payload));
}

Status SettledFiles::clear() {
  const std::lock_guard lock(mutex_);
  index_.reset();
  if (const auto failed = remove_tree(folder_)) return io_error(folder_, "cannot remove it", failed.value());
  return success();
}

}  // namespace tessera
