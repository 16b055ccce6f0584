#include "src/front/apps/far_results.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "src/front/apps/interrupt.h"
#include "src/front/apps/percent_line.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/report/human.h"
#include "src/result/far_copy.h"

namespace tessera::apps {
namespace {

void print_copied(const char* event, const std::string& from, const std::string& to, const result::CopiedResult& copied,
                  const OutputOptions& output) {
  if (output.json) {
    print_json_line({{"event", event},
                     {"result", from},
                     {"output", to},
                     {"files", copied.files},
                     {"bytes", copied.bytes},
                     {"vertices", copied.vertices},
                     {"cells", copied.cells},
                     {"tiles", copied.tiles}});
  } else if (!output.quiet) {
    say("%s: %s vertices, %s cells, %s tiles, %s\n", to.c_str(), grouped(copied.vertices).c_str(),
        grouped(copied.cells).c_str(), grouped(copied.tiles).c_str(), human_bytes(copied.bytes).c_str());
  }
}

Result<result::CopiedResult> send(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                                  const OutputOptions& output, const std::stop_token& stop) {
  auto sent = result::put_result(folder, name, overwrite, percent_line("uploading", output), stop);
  clear_line(output);
  if (!sent && sent.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; " + name + " holds no whole result");
  return sent;
}

}  // namespace

Status fetch_from_store(const std::string& name, const std::filesystem::path& folder, const OutputOptions& output) {
  const Interrupt interrupt;
  auto fetched = result::copy_far_result(name, folder, percent_line("fetching", output), interrupt.token());
  clear_line(output);
  if (!fetched && fetched.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; nothing is kept of " + name);
  BOOST_OUTCOME_TRY(copied, std::move(fetched));
  print_copied("fetched", name, folder.string(), copied, output);
  return success();
}

Status upload_to_store(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                       const OutputOptions& output) {
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(sent, send(folder, name, overwrite, output, interrupt.token()));
  print_copied("uploaded", folder.string(), name, sent, output);
  return success();
}

Status send_to_store(const std::filesystem::path& folder, const std::string& name, bool overwrite,
                     const OutputOptions& output, const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(send(folder, name, overwrite, output, stop));
  return success();
}

}  // namespace tessera::apps
