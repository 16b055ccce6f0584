#include "src/service/data_format.h"

#include <charconv>
#include <string>
#include <system_error>

#include "src/files/names.h"
#include "src/files/whole_file.h"

namespace tessera {
namespace {

// A higher one for what an older version would misread: never for a new field, which it passes over.
constexpr int newest = 1;

}  // namespace

Status check_data_format(const std::filesystem::path& data) {
  const auto file = data_format_file(data);
  std::error_code missing;
  if (!std::filesystem::exists(file, missing)) return write_whole(file, std::to_string(newest) + "\n");
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  const auto text = as_text(bytes);
  int format = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), format);
  if (wrong != std::errc{} || format < 1 || text.substr(static_cast<std::size_t>(end - text.data())) != "\n")
    return error(Errc::corrupt, file.string() + ": is damaged: it holds no number of a format");
  if (format > newest) {
    return error(Errc::corrupt, data.string() + ": was written by a newer version of tesserad: its format is " +
                                    std::to_string(format) + ", this one knows " + std::to_string(newest));
  }
  return success();
}

}  // namespace tessera
