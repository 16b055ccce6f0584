#include "src/front/apps/remote_triangulate.h"

#include <nlohmann/json.hpp>
#include <string>

#include "src/front/apps/interrupt.h"
#include "src/front/apps/remote_inputs.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/watching.h"
#include "src/input/bytes/objects.h"

namespace tessera::apps {
namespace {

Status refuse_what_is_local(const Settings& settings, const TriangulateOptions& options) {
  if (reads_standard_input(options))
    return error(Errc::usage, "standard input cannot be sent to a daemon; save it in a file below one of its folders");
  if (settings.text("input-list").has_value())
    return error(Errc::usage,
                 "--input-list is not for a job of a daemon: name the daemon's files, folders or patterns");
  if (names_object(options.out.string()))
    return error(Errc::usage, options.out.string() +
                                  ": a daemon keeps its results in its data folder, which all nodes share; 'tessera "
                                  "fetch' copies a result from there, and 'tessera upload' sends the copy to a store");
  if (options.resume)
    return error(Errc::usage, "--resume is not for a job of a daemon: 'tessera resume ID' continues one");
  return success();
}

Result<proto::StatusInfo> submit(client::Server& server, const nlohmann::ordered_json& inputs) {
  const Interrupt interrupt;
  auto submitted = server.submit("triangulate", inputs, client::new_idempotency_key(), interrupt.token());
  if (!submitted && submitted.error().code == Errc::interrupted)
    return error(Errc::interrupted, "interrupted; 'tessera jobs' tells whether the daemon has the job");
  return submitted;
}

}  // namespace

Status triangulate_remotely(Settings& settings, const TriangulateOptions& options) {
  BOOST_OUTCOME_TRYV(refuse_what_is_local(settings, options));
  BOOST_OUTCOME_TRY(detach, settings.on("detach"));
  BOOST_OUTCOME_TRY(inputs, remote_inputs(settings, *proto::TriangulateInputs::descriptor(), only_here({"crs"})));
  inputs["inputs"] = options.inputs;
  std::string name = options.out.string();
  while (name.size() > 1 && name.ends_with('/')) name.pop_back();
  inputs["output"] = name;
  // Sends the coordinate system itself, because --crs may name a file of this machine.
  if (!options.job.cloud.crs.empty()) inputs["crs"] = options.job.cloud.crs;
  BOOST_OUTCOME_TRY(server, open_server(settings));
  const auto submitted = submit(server, inputs);
  if (!submitted) return advise_upload(submitted.error(), options.inputs);
  const auto& job = submitted.value();
  if (detach) {
    print_detached(settings, job, options.output);
    return success();
  }
  return watch_job(server, settings, job.job_id(), options.output);
}

}  // namespace tessera::apps
