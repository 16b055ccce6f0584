#include "src/base/files/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "src/base/files/descriptor.h"
#include "src/base/files/whole_file.h"

namespace tessera {

Result<bool> keep_private(const std::filesystem::path& file, Mend mend) {
  BOOST_OUTCOME_TRY(opened, open_handle(file, O_RDONLY | O_NONBLOCK));
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0) return io_error(file, "cannot be examined", errno);
  const uid_t self = ::geteuid();
  const bool handed_over = status.st_uid == 0 && self != 0;
  if (self != 0 && self != status.st_uid && !handed_over)
    return error(Errc::usage, file.string() + ": belongs to another user, who can read it");
  const mode_t too_much = status.st_mode & (S_IRWXG | S_IRWXO) & ~(handed_over ? S_IRGRP : 0U);
  if (too_much == 0) return false;
  const bool mendable = mend == Mend::allowed && self == status.st_uid && (too_much & S_IRWXO) == 0;
  if (mendable && ::fchmod(opened.get(), S_IRUSR | S_IWUSR) == 0) return true;
  return error(Errc::usage,
               file.string() + ": others can read it; its rights must be " + (handed_over ? "0640" : "0600"));
}

Status make_private_folder(const std::filesystem::path& folder) {
  const std::filesystem::path named = folder.has_filename() ? folder : folder.parent_path();
  if (named.has_parent_path()) {
    BOOST_OUTCOME_TRYV(make_directories(named.parent_path()));
  }
  if (::mkdir(named.c_str(), S_IRWXU) != 0 && errno != EEXIST) return io_error(named, "cannot make the folder", errno);
  const auto others = [&] {
    return error(Errc::usage, named.string() + ": belongs to another user; name a folder of this user's own");
  };
  struct stat status {};
  if (::lstat(named.c_str(), &status) != 0) return io_error(named, "cannot be examined", errno);
  if (S_ISLNK(status.st_mode) && status.st_uid != ::geteuid() && status.st_uid != 0) return others();
  BOOST_OUTCOME_TRY(opened, open_handle(named, O_RDONLY | O_DIRECTORY));
  if (::fstat(opened.get(), &status) != 0) return io_error(named, "cannot be examined", errno);
  if (status.st_uid != ::geteuid()) return others();
  if ((status.st_mode & S_IWOTH) != 0)
    return error(Errc::usage, named.string() + ": others can write to it; its rights must be 0700");
  if ((status.st_mode & S_IWGRP) != 0 && ::fchmod(opened.get(), S_IRWXU) != 0)
    return error(Errc::usage, named.string() + ": its group can write to it; its rights must be 0700");
  return success();
}

}  // namespace tessera
