#include "src/job/parse_crs.h"

#include <string_view>

#include "src/base/crs/crs.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/printable.h"

namespace tessera {
namespace {

std::string trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\n";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(blank) - first + 1));
}

}  // namespace

Result<std::string> parse_crs(const std::string& text) {
  std::string crs = text;
  if (!looks_like_crs(crs)) {
    const auto there = is_there(crs);
    if (!there || !there.value()) {
      const auto checked = check_crs(crs);
      return error(Errc::usage, in_quotes(text) + " is no file" + (there ? "" : " (" + there.error().where + ")") +
                                    ": " + checked.error().where);
    }
    BOOST_OUTCOME_TRY(content, read_whole(crs));
    crs = trimmed(as_text(content));
    if (const auto checked = check_crs(crs); !checked)
      return error(Errc::usage, in_quotes(text) + ", a file: " + checked.error().where);
    return crs;
  }
  if (const auto understood = check_crs(crs); !understood)
    return error(Errc::usage, in_quotes(text) + ": " + understood.error().where);
  return crs;
}

}  // namespace tessera
