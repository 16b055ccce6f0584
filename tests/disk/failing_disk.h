// A file system that fails when it is told to: the C library's calls for files and folders in all their forms. Linked
// into a program, it replaces them all.
#pragma once

#include <cerrno>
#include <cstdint>
#include <filesystem>

namespace tessera::testing {

// A broken disk, a server that has forgotten a file, links without end, rights that are missing.
inline constexpr int disk_errors[] = {EIO, ESTALE, ELOOP, EACCES};

// Instead of an error: the process is killed before the call.
inline constexpr int kill_process = -1;

// From now on, of the calls for what is below `folder`, the `first`-th (from 1) and those after it, `count` in all,
// fail with `number` and do nothing else; with `count` 0 none. `folder`: absolute, without links.
void fail_below(const std::filesystem::path& folder, std::uint64_t first, std::uint64_t count, int number);

struct DiskCalls {
  std::uint64_t asked = 0, failed = 0;
};
// None fails any more. What happened since fail_below(), on all threads.
DiskCalls recover_disk();

// Whether the file was synced, rightly, since it was written to for the last time. Only between the two above.
bool was_synced(const std::filesystem::path& file);

}  // namespace tessera::testing
