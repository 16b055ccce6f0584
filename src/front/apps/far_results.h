// Results in object stores: fetch, upload, and -o s3://bucket/folder.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"

namespace tessera::apps {

// Copies the result `name` of a store into a folder, and prints the outcome.
Status fetch_from_store(const std::string& name, const std::filesystem::path& folder, const OutputOptions& output);

// Copies the result in `folder` to a store, and prints the outcome.
Status upload_to_store(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                       const OutputOptions& output);

// The same without printing the outcome. Errors: those of result::put_result().
Status send_to_store(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                     const OutputOptions& output, const std::stop_token& stop);

}  // namespace tessera::apps
