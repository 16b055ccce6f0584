// tessera results and fetch: list and download the results of a daemon.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/there.h"
#include "src/front/apps/command.h"
#include "src/front/apps/far_results.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/job_text.h"
#include "src/front/apps/log.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/remote_heights.h"
#include "src/front/apps/remote_result.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/input/bytes/objects.h"
#include "src/job/report/human.h"
#include "src/service/client/fetch.h"

namespace tessera::apps {
namespace {

Status run_results(Settings& settings) {
  BOOST_OUTCOME_TRY(json, settings.on("json"));
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(results, server.triangulations(interrupt.token()));
  if (!json) say("%s", results_text(results).c_str());
  if (json) {
    for (const auto& result : results) print_json_line(result_json(result));
  }
  return success();
}

// Downloads the files that a job has made of a result.
Status fetch_of_job(client::Server& server, const std::string& id, const std::filesystem::path& path,
                    const OutputOptions& output, const std::stop_token& stop) {
  const auto job = server.job(id, stop);
  if (!job && job.error().code != Errc::usage) return job.error();
  const bool copied = job && job.value().process_id() == "hag";
  if (!job || (job.value().process_id() != "export" && !copied && !is_drawing(job.value())))
    return error(Errc::usage,
                 "there is no result '" + id +
                     "', and no job with this id that makes files of a result; 'tessera results' lists results");
  if (job.value().status() != "successful")
    return error(Errc::usage, "job " + id + " has the status " + job.value().status() + ": there is nothing to fetch");
  if (copied) return fetch_heights(server, job.value(), path, false, output, stop);
  const auto taken = error(Errc::usage, path.string() + ": exists already; give another name");
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (is_drawing(job.value())) {
    if (there) return taken;
    return fetch_drawing(server, job.value(), path, output, stop);
  }
  BOOST_OUTCOME_TRY(stands, is_folder(path));
  const bool folder = !path.has_filename() || !path.has_extension() || stands;
  if (there && !stands) return taken;
  if (stands) {
    BOOST_OUTCOME_TRY(empty, is_empty_folder(path));
    if (!empty) return taken;
  }
  const ExportTarget target{.path = path.has_filename() ? path : path.parent_path(), .folder = folder};
  return fetch_export(server, job.value(), "", target, "", "", output, stop);
}

Status run_fetch(Settings& settings, const std::string& name) {
  const std::filesystem::path folder = settings.text("output").value_or("");
  if (name.empty()) return error(Errc::usage, "no result is given; 'tessera results' lists them");
  if (folder.empty()) return error(Errc::usage, "no folder is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  if (names_object(name)) return fetch_from_store(name, folder, output);
  BOOST_OUTCOME_TRY(server, open_server(settings));
  if (output.verbose) log_everything();
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(known, server.triangulation(name, interrupt.token()));
  if (!known) return fetch_of_job(server, name, folder, output, interrupt.token());
  auto result = client::fetch_result(
      server, name, folder,
      [line = percent_line("fetching", output)](const client::FetchProgress& now) { line(now.bytes, now.bytes_total); },
      interrupt.token());
  clear_line(output);
  if (!result && result.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; the same command continues");
  BOOST_OUTCOME_TRY(fetched, std::move(result));
  if (output.json) {
    print_json_line({{"event", "fetched"},
                     {"result", name},
                     {"output", folder.string()},
                     {"files", fetched.files},
                     {"bytes", fetched.bytes},
                     {"vertices", fetched.vertices},
                     {"cells", fetched.cells},
                     {"tiles", fetched.tiles}});
  } else if (!output.quiet) {
    say("%s: %s vertices, %s cells, %s tiles, %s\n", folder.c_str(), grouped(fetched.vertices).c_str(),
        grouped(fetched.cells).c_str(), grouped(fetched.tiles).c_str(), human_bytes(fetched.bytes).c_str());
  }
  return success();
}

}  // namespace

Command add_results(CLI::App& root) {
  auto command = new_command(root, "results", "Lists the results that a daemon has",
                             "  tessera results --server http://127.0.0.1:7070\n"
                             "  tessera results --json");
  set_group(command, daemon_group);
  add_server_options(command);
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  command.run = [settings = command.settings.get()](const std::vector<std::string>&) { return run_results(*settings); };
  return command;
}

Command add_fetch(CLI::App& root) {
  auto command = new_command(
      root, "fetch", "Copies a result of a daemon or of an object store into a folder here, and checks every file",
      "  tessera fetch NAME -o out/ --server http://127.0.0.1:7070\n"
      "  tessera fetch NAME -o out/      (again, after Ctrl-C: continues where it was)\n"
      "  tessera fetch ID -o mesh.ply    (the files that a job has made of a result, as export or dem)\n"
      "  tessera fetch s3://bucket/folder -o out/");
  set_group(command, daemon_group);
  add_value(command, "output", "FOLDER",
            "for a result: a folder that is new, empty, or left by an earlier fetch; for the files of a job: the file "
            "or folder to write",
            'o', true);
  add_store_options(command);
  add_server_options(command);
  add_output_switches(command);
  auto name = std::make_shared<std::string>();
  add_argument(
      command, "result", "NAME", *name,
      "the name of a result, as 'tessera results' shows it; or the id of a job that made files of one, as export "
      "or dem; or the place of a result, as s3://bucket/folder or https://host/folder");
  command.run = [settings = command.settings.get(), name](const std::vector<std::string>&) {
    return run_fetch(*settings, *name);
  };
  return command;
}

}  // namespace tessera::apps
