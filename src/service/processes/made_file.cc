#include "src/service/processes/made_file.h"

#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/result/tileset/tileset.h"

namespace tessera::service {
namespace {

using Json = nlohmann::ordered_json;

// The files that an export has made in `folder`: their paths in the result, bytes and checksums.
Result<Json> written_files(const std::filesystem::path& folder) {
  Json list = Json::array();
  std::vector<std::filesystem::path> folders{""};
  while (!folders.empty()) {
    const auto inside = std::move(folders.back());
    folders.pop_back();
    FolderReader reader(folder / inside);
    while (const char* name = reader.next()) {
      const auto path = inside / name;
      BOOST_OUTCOME_TRY(below, is_folder(folder / path));
      if (below) {
        folders.push_back(path);
        continue;
      }
      BOOST_OUTCOME_TRY(sum, checksum_file(folder / path));
      BOOST_OUTCOME_TRY(bytes, file_bytes(folder / path));
      list.push_back({{"path", (exports_folder("") / path).string()}, {"bytes", bytes}, {"xxh3", checksum_text(sum)}});
    }
    if (reader.error()) return io_error(folder / inside, "cannot be listed", reader.error().value());
  }
  return list;
}

}  // namespace

std::optional<proto::Problem> check_ending(const proto::Inputs& inputs, std::initializer_list<const char*> endings) {
  const std::string output = *export_output(inputs);
  std::string all;
  for (const char* ending : endings) {
    if (output.ends_with(ending)) return std::nullopt;
    all += (all.empty() ? "" : ending == *std::prev(endings.end()) ? " or " : ", ") + std::string(ending);
  }
  return problem(400, "output: '" + output + "' must end in " + all, Errc::usage);
}

std::function<void(double)> percentage(const JobWork& work) {
  return [&work](double part) {
    work.progress.points_total = 100;
    work.progress.points_triangulated = static_cast<std::uint64_t>(part * 100);
  };
}

Reply<JobDone> done_with_tileset(const std::string& told, const std::string& output) {
  Json outcome = parse_ordered_json(told);
  outcome["output"] = output;
  outcome["written"] =
      Json::array({Json{{"path", tileset_file(exports_folder("") / output).string()}, {"bytes", outcome.at("bytes")}}});
  return JobDone{json_text(outcome) + "\n", 0, {}};
}

Reply<JobDone> done_with(const std::filesystem::path& folder, const std::string& told, const std::string& output) {
  auto written = written_files(folder);
  if (!written) return problem_of(written.error());
  Json outcome = parse_ordered_json(told);
  outcome["output"] = output;
  outcome["written"] = std::move(written).value();
  return JobDone{json_text(outcome) + "\n", 0, {}};
}

}  // namespace tessera::service
