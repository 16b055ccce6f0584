#include "src/service/data_format.h"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <string>

#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/random_token.h"

namespace tessera::service {
namespace {

// To be raised when an older version would misread the folder; not for a new field, which older versions ignore.
constexpr int newest = 1;

}  // namespace

Status check_data_format(const std::filesystem::path& data) {
  const auto file = data_format_file(data);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return write_whole(file, std::to_string(newest) + "\n");
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  const auto text = as_text(bytes);
  int format = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), format);
  if (wrong != std::errc{} || format < 1 || text.substr(static_cast<std::size_t>(end - text.data())) != "\n")
    return error(Errc::corrupt, file.string() + ": is damaged: it must hold the number of the data folder's format");
  if (format > newest) {
    return error(Errc::corrupt, data.string() + ": was written by a newer version of tesserad: its format is " +
                                    std::to_string(format) + ", and this version reads formats up to " +
                                    std::to_string(newest));
  }
  return success();
}

Result<std::string> data_identity(const std::filesystem::path& data) {
  const auto file = data_identity_file(data);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) {
    TemporaryFile temporary(temporary_name_of_process(file));
    BOOST_OUTCOME_TRYV(write_whole(temporary.path(), random_token() + random_token() + "\n"));
    // The first daemon wins, and all read the same identity.
    if (::link(temporary.path().c_str(), file.c_str()) != 0 && errno != EEXIST)
      return io_error(file, "cannot be made", errno);
  }
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  if (bytes.empty()) return error(Errc::corrupt, file.string() + ": is damaged: it is empty");
  return std::string(as_text(bytes));
}

}  // namespace tessera::service
