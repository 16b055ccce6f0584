#include "src/service/results/owners.h"

#include "src/base/files/data_names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera::service {

bool may_remove(const std::string& owner, const Caller& caller) {
  return caller.role >= Role::admin || (caller.role >= Role::submit && !owner.empty() && owner == caller.name);
}

Result<std::string> owner_of(const std::filesystem::path& path) {
  const auto file = owner_file(path);
  BOOST_OUTCOME_TRY(known, is_there(file, FollowLinks::no));
  if (!known) return std::string();
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  return std::string(as_text(bytes));
}

Status set_owner(StagingFolder& desk, const std::filesystem::path& path, const std::string& owner) {
  return desk.write(owner_file(path), owner);
}

Status forget_owner(const std::filesystem::path& path) { return remove_file(owner_file(path)); }

}  // namespace tessera::service
