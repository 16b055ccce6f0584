#include "src/delaunay/run/settled_stages.h"

#include <string_view>

#include "src/base/files/folder.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

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
  BOOST_OUTCOME_TRYV(remove_file(marker));
  return remove_whole(scratch_folder(folder, ScratchKind::settled));
}

}  // namespace tessera
