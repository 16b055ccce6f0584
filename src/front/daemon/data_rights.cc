#include "src/front/daemon/data_rights.h"

#include <sys/stat.h>
#include <unistd.h>

#include "src/base/files/there.h"

namespace tessera::daemon {

Result<std::optional<std::string>> who_else_may_enter(const std::filesystem::path& data) {
  BOOST_OUTCOME_TRY(found, look_at(data));
  const bool others = found && (found->st_mode & S_IRWXO) != 0;
  const bool group = found && (found->st_mode & S_IRWXG) != 0 && found->st_gid != ::getegid();
  if (!others && !group) return std::optional<std::string>();
  return std::optional(data.string() + ": " + (others ? "other users" : "the users of its group") +
                       " can read this folder, with its jobs and results; 'chmod 700' keeps them out");
}

}  // namespace tessera::daemon
