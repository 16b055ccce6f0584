// Who made what: the name of a token, kept beside an export or an upload for as long as it is there, whatever is still
// known of the job. That of a result is in its manifest (Results::maker).
#pragma once

#include <filesystem>
#include <string>

#include "src/base/result.h"
#include "src/service/service.h"
#include "src/service/staging_folder.h"

namespace tessera {

// Whether the caller may remove what `owner` has made, and so put something else in its place. Nobody knows the
// `owner` of what is from before owners were kept: empty.
bool may_remove(const std::string& owner, const Caller& caller);

// Of the export or upload at `path`; empty when nobody knows. What is kept of one that is gone means nothing: look
// whether it is there first. Error io.
Result<std::string> owner_of(const std::filesystem::path& path);
// Before there is anything at `path`, so that it is never without. Error io.
Status set_owner(StagingFolder& desk, const std::filesystem::path& path, const std::string& owner);
Status forget_owner(const std::filesystem::path& path);

}  // namespace tessera
