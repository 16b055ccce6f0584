#include "src/delaunay/update/made_mark.h"

#include <nlohmann/json.hpp>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"

namespace tessera {

namespace {

using MarkJson = nlohmann::ordered_json;

}  // namespace

Status write_mark(const std::filesystem::path& run, const MadeMark& mark) {
  return write_whole(outcome_file(run),
                     json_text(MarkJson{{"manifest", mark.manifest}, {"command", mark.command}}) + "\n");
}

Result<std::optional<MadeMark>> read_mark(const std::filesystem::path& run) {
  const std::filesystem::path file = outcome_file(run);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return std::optional<MadeMark>();
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  try {
    const MarkJson json = parse_ordered_json(as_text(bytes));
    MadeMark mark;
    json.at("manifest").get_to(mark.manifest);
    json.at("command").get_to(mark.command);
    return std::optional(std::move(mark));
  } catch (const MarkJson::exception&) {
    return error(Errc::corrupt, file.string() + ": is damaged, or not the mark of a change");
  }
}

Result<bool> is_made(const MadeMark& mark, const std::filesystem::path& out) {
  BOOST_OUTCOME_TRY(there, is_there(manifest_file(out)));
  if (!there) return false;
  BOOST_OUTCOME_TRY(sum, checksum_file(manifest_file(out)));
  return checksum_text(sum) == mark.manifest;
}

}  // namespace tessera
