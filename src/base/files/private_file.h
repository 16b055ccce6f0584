// Files that hold a secret, and folders that nobody else may put anything into.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

enum class Mend : bool { refused, allowed };

// Whether nobody but its owner, who is this user or root, can read `file`; the group may read what is root's, which is
// how service managers hand a secret to a process of another user. With Mend::allowed rights of the group alone are
// taken away from a file that is ours, and true is returned: Kubernetes gives them to every file of a volume that it
// mounts again (fsGroup). Errors: usage for a file that others can read, or that belongs to others; io.
Result<bool> keep_private(const std::filesystem::path& file, Mend mend);

// Makes the folder when it is missing, with those above it, for this user alone. Errors: usage for one that is another
// user's, or a link of another's, and for one that others can write to; io. Rights of the group are taken away, as
// above.
Status make_private_folder(const std::filesystem::path& folder);

}  // namespace tessera
