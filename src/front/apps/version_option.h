// The option --version of commands that read a result.
#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"

namespace tessera::apps {

void add_version_option(Command& command);
// Returns the path that stands for this folder's version (named_version()): the folder itself without the option, and
// with --server, because the daemon gets the option. Error usage.
Result<std::string> at_version(const Settings& settings, const std::string& folder);

// For LockOptions::locked: waits until the other process gives up the lock, or a stop is requested.
std::function<bool(const Error&)> wait_for_lock(std::stop_token stop);

}  // namespace tessera::apps
