// What the processes that make an export have in common: where it is made, and what is told of it.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/service/problem.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {

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

// The problem of a file whose name ends otherwise.
std::optional<proto::Problem> check_ending(const proto::Inputs& inputs, std::initializer_list<const char*> endings);

// Reports progress as a percentage, because there may be no points.
std::function<void(double)> percentage(const JobWork& work);

// What is told of a job. `told` is JSON of what was made in `folder`, which is named `output`.
Reply<JobDone> done_with(const std::filesystem::path& folder, const std::string& told, const std::string& output);
// The same for a set of 3D tiles. `told` is JSON of what was made, with its bytes. Of the many files, only the document
// is named.
Reply<JobDone> done_with_tileset(const std::string& told, const std::string& output);

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
    return write(shop.results.folder(name, version_read(inputs)), folder / output, options.value(),
                 work.ledger.token());
  });
  if (!made) return problem_of(made.error());
  if (!made.value().note.empty()) work.log("note: " + made.value().note);
  return done_with(folder, to_json(made.value()), output);
}

}  // namespace tessera::service
