// The process hag.
#include <utility>

#include "src/base/files/heights_names.h"
#include "src/base/files/whole_file.h"
#include "src/job/report/human.h"
#include "src/result/heights/copies.h"
#include "src/service/naming.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::string usual_heights(const proto::Inputs& /*inputs*/) { return heights_of_result("").filename().string(); }

std::optional<proto::Problem> check_hag_options(const proto::Inputs& inputs, const JobShare& share) {
  if (auto bad = problem_if(heights_options(inputs.hag(), share))) return bad;
  // Other parts of the daemon look for files by these endings.
  const std::string output = *export_output(inputs);
  if (std::filesystem::path(output).extension().empty()) return std::nullopt;
  return problem(400, "output: '" + output + "' must have no ending, because it becomes a folder of files",
                 Errc::usage);
}

std::optional<proto::Problem> check_hag(const Workshop& shop, const proto::Inputs& inputs) {
  const auto manifest = shop.results.manifest(result_read(inputs), version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  if (auto none = no_heights(*manifest.value(), result_read(inputs))) return none;
  return check_files(shop, inputs.hag().inputs(), inputs.hag().recursive());
}

// The files and their copies in the folder `to`, which is made when all of them can be copied.
Result<std::vector<HeightsFile>> plan(const Workshop& shop, const proto::HagInputs& inputs,
                                      const std::filesystem::path& to, const HeightsOptions& options) {
  BOOST_OUTCOME_TRY(names, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  BOOST_OUTCOME_TRY(packed, any_packed(names));
  if (packed) return error(Errc::bad_input, "inputs: compressed files must be unpacked first");
  BOOST_OUTCOME_TRY(files, plan_copies(names, to, options, false));
  for (const auto& file : files) {
    const auto fits = check_name(file.to.filename().string());
    if (!fits) return error(Errc::bad_input, file.from.string() + ": has a name that " + fits.error().where);
  }
  BOOST_OUTCOME_TRYV(make_directories(to));
  return files;
}

Reply<JobDone> run_hag(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().hag();
  auto read = heights_options(inputs, shop.share);
  if (!read) return problem_of(read.error());
  HeightsOptions options = std::move(read).value();
  options.stop = work.ledger.token();
  const std::string name = result_read(work.job.inputs()), output = *export_output(work.job.inputs());
  const auto share = share_of_job(inputs, shop.share);
  if (!share) return problem_of(share.error());
  const auto folder = shop.results.unfinished_export(name, work.job.id());
  auto made = written_aside(shop, folder, work, [&]() -> Result<std::vector<HeightsFile>> {
    BOOST_OUTCOME_TRY(files, plan(shop, inputs, folder / output, options));
    BOOST_OUTCOME_TRY(ground, query::StoredTriangulation::open(shop.results.folder(name, inputs.version()),
                                                               {.memory_bytes = share.value().memory_bytes}));
    BOOST_OUTCOME_TRYV(write_copies(ground, files, options, percentage(work)));
    return std::move(files);
  });
  if (!made) return problem_of(made.error());
  if (const auto all = all_copies(made.value()); all.outside > 0)
    work.log("note: " + grouped(all.outside) + " of " + grouped(all.points) +
             " points are outside of the hull of the ground");
  for (auto& file : made.value()) {
    file.from = shop.roots.named(file.from.string());
    file.to = file.to.filename();
  }
  return done_with(folder, to_json(made.value()), output);
}

}  // namespace

constinit const Process hag_process{
    .name = "hag",
    .title = "Heights above the ground",
    .description =
        "Copies LAS and LAZ files, and gives each point the dimension HeightAboveGround: its height above a 2D result, "
        "the ground. Everything else in the files stays as it is.",
    .outcome = "The copies, by reference",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .usual_output = usual_heights,
    .check_options = check_hag_options,
    .check = check_hag,
    .run = run_hag};

}  // namespace tessera::service
