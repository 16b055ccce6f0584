// More names in the data folder of a service (names.h), of what says who may do what:
//
//   DATA/sessions                  browsers that have shown a token (src/service/http/sessions.h)
//   .../.NAME.owner                who made the export or upload NAME (src/service/owners.h)
#pragma once

#include <filesystem>

namespace tessera {

std::filesystem::path sessions_file(const std::filesystem::path& data);
// Beside it.
std::filesystem::path owner_file(const std::filesystem::path& of);

}  // namespace tessera
