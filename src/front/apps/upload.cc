// tessera upload: sends files to a daemon, as inputs for its jobs; or a result to an object store.
#include "src/service/client/upload.h"
#include "src/front/apps/say.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "src/base/files/there.h"
#include "src/front/apps/command.h"
#include "src/front/apps/far_results.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/input/bytes/objects.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

Status check_files(const std::vector<std::string>& files) {
  std::set<std::string> names;
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(found, look_at(file));
    if (found && S_ISDIR(found->st_mode)) return error(Errc::usage, file + ": is a folder; name the files in it");
    if (!found) return error(Errc::io, file + ": there is no such file");
    if (!names.insert(fs::path(file).filename()).second)
      return error(Errc::usage, file + ": another file to send has the same name; send them to two folders");
  }
  return success();
}

Status run_upload(Settings& settings, const std::vector<std::string>& files) {
  auto folder = settings.text("output").value_or("");
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  if (files.empty()) return error(Errc::usage, "no file to send is given; try 'tessera upload --help'");
  if (folder.empty()) return error(Errc::usage, "no folder is given; add -o NAME");
  BOOST_OUTCOME_TRY(output, output_options(settings));
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  if (names_object(folder)) {
    if (files.size() != 1) return error(Errc::usage, folder + ": give one result folder to send there, not several");
    return upload_to_store(files.front(), folder, overwrite, output);
  }
  if (overwrite) return error(Errc::usage, "--overwrite is for results in object stores; a daemon replaces files");
  BOOST_OUTCOME_TRY(server, open_server(settings));
  BOOST_OUTCOME_TRYV(check_files(files));
  if (output.verbose) log_everything();
  const Interrupt interrupt;
  for (const auto& file : files) {
    const auto name = fs::path(file).filename().string();
    BOOST_OUTCOME_TRY(there, bytes_if_there(file));
    const auto size = there.value_or(0);  // the size of a pipe is not known
    const auto line = percent_line("sending " + name + ":", output);
    const auto sent = client::upload(
        server, file, folder, name, [&](std::uint64_t bytes) { line(bytes, size); }, interrupt.token());
    clear_line(output);
    if (!sent && sent.error().code == Errc::interrupted)
      return error(Errc::interrupted, "interrupted; " + file + " has not been sent");
    if (!sent) return sent.error();
    const auto input = "upload:" + folder + "/" + name;
    if (output.json) {
      print_json_line({{"event", "uploaded"}, {"input", input}, {"bytes", sent.value()}});
    } else if (!output.quiet) {
      say("%s: %s\n", input.c_str(), human_bytes(sent.value()).c_str());
    }
  }
  return success();
}

}  // namespace

Command add_upload(CLI::App& root) {
  auto command = new_command(
      root, "upload", "Sends files to a daemon, for its jobs to read; or a result to an object store",
      "  tessera upload block/*.laz -o block --server http://127.0.0.1:7070\n"
      "  tessera triangulate upload:block -o block      (all of them; or upload:block/a.laz)\n"
      "  tessera upload out/ -o s3://bucket/folder      (a result folder)\n\n"
      "A daemon takes files if it was started with --uploads. When a connection ends, the upload continues\n"
      "on a new one. Files of the same names at the daemon are replaced.");
  set_group(command, daemon_group);
  add_value(command, "output", "NAME",
            "the folder at the daemon, which jobs call upload:NAME; or for a result s3://bucket/folder", 'o', true);
  add_switch(command, "overwrite", "s3://: replace a result that is there", 0, true);
  add_store_options(command);
  add_server_options(command);
  add_output_switches(command);
  auto files = std::make_shared<std::vector<std::string>>();
  add_argument(command, "files", "FILE", *files, "point files of this machine; or one result folder");
  command.run = [settings = command.settings.get(), files](const std::vector<std::string>&) {
    return run_upload(*settings, *files);
  };
  return command;
}

}  // namespace tessera::apps
