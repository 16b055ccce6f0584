// Files that contain a secret, and folders into which no other user may put anything.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

enum class Mend : bool { refused, allowed };

// Checks that only the file's owner, this user or root, can read `file`. The group may read a file of root: that is how
// service managers hand a secret to a process of another user. With Mend::allowed, rights that only the group has too
// much are taken away from a file of this user, and true is returned. Kubernetes gives such rights to every file of a
// volume that it mounts again (fsGroup). Errors: usage for a file that others can read or that belongs to others; io.
Result<bool> keep_private(const std::filesystem::path& file, Mend mend);

// Makes the folder for this user alone when it is missing, with the folders above it. Errors: usage for a folder or a
// link that belongs to another user, and for a folder to which others can write; io. If only the group can write, the
// group's rights are taken away.
Status make_private_folder(const std::filesystem::path& folder);

}  // namespace tessera
