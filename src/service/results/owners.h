// Keeps the owner of each export and upload: the name of the token, in a file beside it, also when the job is
// forgotten. The owner of a result is in its manifest (ResultFolders::maker).
#pragma once

#include <filesystem>
#include <string>

#include "src/base/result.h"
#include "src/service/caller.h"
#include "src/service/staging_folder.h"

namespace tessera::service {

// True if the caller may remove what `owner` has made, and so replace it. `owner` is empty when unknown, as for files
// from before owners were kept.
bool may_remove(const std::string& owner, const Caller& caller);

// The owner of the export or upload at `path`; empty when unknown. The answer means nothing when there is no file:
// check that first. Error io.
Result<std::string> owner_of(const std::filesystem::path& path);
// Call this before the file exists, so that the file always has an owner. Error io.
Status set_owner(StagingFolder& desk, const std::filesystem::path& path, const std::string& owner);
Status forget_owner(const std::filesystem::path& path);

}  // namespace tessera::service
