#include "src/run/next_stage.h"

#include <string>
#include <string_view>
#include <system_error>

#include "src/files/folder.h"
#include "src/files/folder_lock.h"
#include "src/files/names.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"

namespace tessera {

Result<std::uint32_t> settled_stages(const std::filesystem::path& run, std::uint32_t stages) {
  std::uint32_t settled = 0;
  for (; settled < stages; ++settled) {
    BOOST_OUTCOME_TRY(marked, is_there(settled_marker(stage_folder(run, settled))));
    if (!marked) break;
  }
  return settled;
}

Status mark_settled(const std::filesystem::path& run, std::uint32_t stage, const std::filesystem::path& lock_file,
                    bool settled) {
  BOOST_OUTCOME_TRYV(check_held(lock_file));
  const auto folder = stage_folder(run, stage);
  const auto marker = settled_marker(folder);
  if (settled) {
    BOOST_OUTCOME_TRYV(make_directories(folder));
    return write_whole(marker, std::string_view("settled\n"));
  }
  std::error_code failed;
  std::filesystem::remove(marker, failed);
  if (failed) return error(Errc::io, marker.string() + ": cannot remove it: " + failed.message());
  const auto files = scratch_folder(folder, ScratchKind::settled);
  if (const auto left = remove_tree(files))
    return error(Errc::io, files.string() + ": cannot remove it: " + left.message());
  return success();
}

}  // namespace tessera
