#include "src/result/density/sums.h"

#include <span>
#include <string>

namespace tessera::density {

Result<SumFile> SumFile::create(const std::filesystem::path& folder, std::size_t sums) {
  BOOST_OUTCOME_TRY(file, nameless_file(folder));
  return SumFile(folder, std::move(file), sums);
}

Status SumFile::add(ThreadSums& more) {
  const std::lock_guard lock(*mutex_);
  BlockSums old(static_cast<std::size_t>(voxels_a_block) * sums_);
  for (auto& [number, block] : more.take()) {
    BOOST_OUTCOME_TRY(known, read(number, old));
    if (known) {
      for (std::size_t i = 0; i < old.size(); ++i) (*block)[i].add(old[i]);
    } else {
      const std::uint64_t place = places_.size();
      places_.emplace(number, place);
    }
    const auto bytes = std::as_bytes(std::span(*block));
    BOOST_OUTCOME_TRYV(write_at(file_.get(), bytes, places_.at(number) * bytes.size(), folder_,
                                "cannot write the sums of the grid into this folder"));
  }
  return success();
}

Result<bool> SumFile::read(std::int64_t number, BlockSums& block) const {
  const auto found = places_.find(number);
  if (found == places_.end()) return false;
  block.resize(static_cast<std::size_t>(voxels_a_block) * sums_);
  const auto bytes = std::as_writable_bytes(std::span(block));
  BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), bytes, found->second * bytes.size(), folder_));
  if (read < bytes.size())
    return error(Errc::io, folder_.string() + ": the file with the sums of the grid is shorter than it was");
  return true;
}

}  // namespace tessera::density
