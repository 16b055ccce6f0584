// More names in the data folder of a service (names.h), of files that say who may do what:
//
//   DATA/sessions                  browsers that have shown a token (src/service/http/sessions.h)
//   .../.NAME.owner                who made the export or upload NAME (src/service/results/owners.h)
#pragma once

#include <filesystem>

namespace tessera {

std::filesystem::path sessions_file(const std::filesystem::path& data);
// The owner file beside the export or upload `of`.
std::filesystem::path owner_file(const std::filesystem::path& of);

}  // namespace tessera
