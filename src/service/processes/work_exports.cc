#include "src/service/processes/work_exports.h"

#include <functional>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/surface_names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/job/engine_steps.h"
#include "src/result/export/export.h"
#include "src/result/tileset/tileset.h"
#include "src/service/processes/drawing_options.h"
#include "src/service/processes/kinds.h"
#include "src/service/problem.h"

namespace tessera {
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

// Returns what `write` has made in the job's folder; on an error removes it. `begun` is the folder that `write` makes
// first; it is kept when the job was interrupted, or found too little disk or memory for a time, so that the job can
// continue later.
template <class Write>
auto written_aside(const Workshop& shop, const std::filesystem::path& folder, const JobWork& work, const Write& write,
                   const std::filesystem::path& begun = {}) {
  const std::string name = result_read(work.job.inputs());
  auto made = [&]() -> decltype(write()) {
    BOOST_OUTCOME_TRYV(shop.results.drop_unfinished_export(name, work.job.id(), begun));
    BOOST_OUTCOME_TRYV(make_directories(folder));
    try {
      return write();
    } catch (const Stopped& stopped) {
      return error(Errc::interrupted, stopped.what());
    } catch (const std::bad_alloc&) {
      return worded([] { return error(Errc::memory, "the system has no more memory to give"); });
    }
  }();
  if (!made) {
    // A job beyond its bound of memory or disk would exceed it again.
    const auto reason = work.ledger.reason();
    const Errc code = reason.value_or(made.error()).code;
    const bool later = code == Errc::interrupted || code == Errc::io || (code == Errc::memory && !reason);
    if (const Status gone = shop.results.drop_unfinished_export(name, work.job.id(), later ? begun : ""); !gone)
      work.log(gone.error().where);
    std::error_code others;
    std::filesystem::remove(folder.parent_path(), others);  // fails, as it should, unless it is empty
  }
  return made;
}

// Reports progress as a percentage, because there may be no points.
std::function<void(double)> percentage(const JobWork& work) {
  return [&work](double part) {
    work.progress.points_total = 100;
    work.progress.points_triangulated = static_cast<std::uint64_t>(part * 100);
  };
}

// `told` is JSON of what was made, with its bytes. Of the many files, only the document is named.
Reply<JobDone> done_with_tileset(const std::string& told, const std::string& output) {
  Json outcome = parse_ordered_json(told);
  outcome["output"] = output;
  outcome["written"] =
      Json::array({Json{{"path", tileset_file(exports_folder("") / output).string()}, {"bytes", outcome.at("bytes")}}});
  return JobDone{json_text(outcome) + "\n", 0, {}};
}

Reply<JobDone> export_tileset(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.has_heights() || inputs.has_spatial_index() || inputs.local())
    return problem(400, "format: 3dtiles takes neither heights nor spatial_index nor local", Errc::usage);
  TilesetOptions options{.memory_bytes = shop.share.memory_bytes, .progress = percentage(work)};
  if (inputs.has_max_edge()) options.max_edge = inputs.max_edge();
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto made = written_aside(shop, folder, work, [&] {
    return write_tileset(shop.results.folder(inputs.triangulation()), folder / inputs.output(), options,
                         work.ledger.token());
  });
  if (!made) return problem_of(made.error());
  return done_with_tileset(to_json(made.value()), inputs.output());
}

// `told` is JSON of what was made in `folder`, which is named `output`.
Reply<JobDone> done_with(const std::filesystem::path& folder, const std::string& told, const std::string& output) {
  auto written = written_files(folder);
  if (!written) return problem_of(written.error());
  Json outcome = parse_ordered_json(told);
  outcome["output"] = output;
  outcome["written"] = std::move(written).value();
  return JobDone{json_text(outcome) + "\n", 0, {}};
}

// A file that terrain draws. `write` gets the result's folder and the path of the file.
template <class Options, class Write>
Reply<JobDone> draw(const Workshop& shop, const JobWork& work, Result<Options> options, const Write& write) {
  if (!options) return problem_of(options.error());
  options.value().progress = percentage(work);
  options.value().overwrite = true;  // files of an earlier attempt; existing exports were checked before
  const auto& inputs = work.job.inputs();
  const std::string name = result_read(inputs), output = *export_output(inputs);
  const auto folder = shop.results.unfinished_export(name, work.job.id());
  const auto made = written_aside(shop, folder, work, [&] {
    return write(shop.results.folder(name), folder / output, options.value(), work.ledger.token());
  });
  if (!made) return problem_of(made.error());
  if (!made.value().note.empty()) work.log("note: " + made.value().note);
  return done_with(folder, to_json(made.value()), output);
}

}  // namespace

Reply<JobDone> do_export(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().export_();
  if (inputs.format() == tileset_format) return export_tileset(shop, work);
  auto options = export_options(inputs);
  if (!options) return problem_of(options.error());
  options.value().overwrite = true;  // files of an earlier attempt; existing exports were checked before
  options.value().progress = percentage(work);
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto exported = written_aside(shop, folder, work, [&] {
    // A name without an ending means a folder of files.
    return export_result(shop.results.folder(inputs.triangulation()), folder / inputs.output(), options.value(),
                         work.ledger.token());
  });
  if (!exported) return problem_of(exported.error());
  const auto& made = exported.value();
  if (!made.note.empty()) work.log("note: " + made.note);
  const std::string output = made.path.filename().string();
  return done_with(folder, to_json(made, output), output);
}

Reply<JobDone> do_dem(const Workshop& shop, const JobWork& work) {
  return draw(shop, work, dem_options(work.job.inputs().dem(), shop.share), write_dem);
}

Reply<JobDone> do_contours(const Workshop& shop, const JobWork& work) {
  return draw(shop, work, contour_options(work.job.inputs().contours(), shop.share), write_contours);
}

Reply<JobDone> do_surface(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs();
  auto options = surface_options(inputs.surface(), shop.share);
  if (!options) return problem_of(options.error());
  options.value().output.overwrite = true;  // files of an earlier attempt; existing exports were checked before
  options.value().progress = percentage(work);
  const std::string name = result_read(inputs), output = *export_output(inputs);
  const auto folder = shop.results.unfinished_export(name, work.job.id());
  options.value().resume = true;
  options.value().lock = lock_of_unfinished(shop, work.ledger.token());
  const auto begun = surface_run_folder(folder / output);
  const auto there = is_there(begun);
  if (!there) return problem_of(there.error());
  if (there.value()) work.log("goes on with what is there");
  const auto write = [&] {
    EngineSteps steps(
        shop.engine,
        {.threads = options.value().threads, .memory_bytes = options.value().memory_bytes, .resumable = true},
        work.progress);
    return make_surface(shop.results.folder(name), folder / output, options.value(), steps, work.ledger.token());
  };
  const auto made = written_aside(shop, folder, work, write, begun.filename());
  if (!made) return problem_of(made.error());
  work.log(made.value().sensors);
  if (!made.value().mesh.note.empty()) work.log("note: " + made.value().mesh.note);
  const std::string told = to_json(made.value(), output);
  if (inputs.surface().format() == tileset_format) return done_with_tileset(told, output);
  return done_with(folder, told, output);
}

}  // namespace tessera
