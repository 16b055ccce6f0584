// The process info.
#include "src/service/processes/info.h"

#include "src/job/describe.h"
#include "src/job/estimate.h"
#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/service/problem.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

constexpr std::size_t described_at_once_max = 10'000;  // files: some seconds

}  // namespace

Result<std::optional<proto::Problem>> takes_too_long(const Workshop& shop, const proto::InfoInputs& inputs,
                                                     std::uint64_t points_max) {
  using Refused = std::optional<proto::Problem>;
  if (!inputs.triangulation().empty()) return Refused{};
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  const auto found = shop.roots.files(list_of(inputs.inputs()), inputs.recursive());
  if (Ledger::reason_of_thread()) return Refused(needs_a_job("inputs: so many files as these"));
  if (!found) return found.error();
  const auto& files = found.value();
  if (files.size() > described_at_once_max) return Refused(needs_a_job("inputs: " + grouped(files.size()) + " files"));
  BOOST_OUTCOME_TRY(packed, any_packed(files));
  if (packed) return Refused(needs_a_job("inputs: compressed files"));
  if (!inputs.stats()) return Refused{};
  BOOST_OUTCOME_TRY(opened, open_cloud(files, options, Ledger::token_of_thread()));
  const auto points = expected_points(opened.files());
  if (points > points_max) return Refused(needs_a_job("inputs: " + grouped(points) + " points"));
  return Refused{};
}

Result<std::string> describe_inputs(const Workshop& shop, const proto::InfoInputs& inputs,
                                    const std::stop_token& stop) {
  DescribeOptions how{.json = true, .statistics = inputs.stats(), .names = field_name};
  if (!inputs.triangulation().empty()) {
    if (inputs.inputs_size() > 0) return error(Errc::usage, "inputs: cannot be given together with triangulation");
    BOOST_OUTCOME_TRY(there, shop.results.exists(inputs.triangulation()));
    if (!there) return error(Errc::usage, "triangulation: there is none called '" + inputs.triangulation() + "'");
    return describe_result(shop.results.folder(inputs.triangulation()), true);
  }
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  options.cloud.spool_folder = shop.data;
  options.cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  auto described = describe(files, std::move(options), how, stop);
  if (described.error) return *described.error;
  return std::move(described.text);
}

namespace {

std::optional<proto::Problem> check_info_options(const proto::Inputs& inputs, const JobShare& share) {
  const auto cloud = cloud_of(inputs.info());
  return cloud ? problem_if(job_options(cloud.value(), share)) : problem_of(cloud.error());
}

std::optional<proto::Problem> check_info(const Workshop& shop, const proto::Inputs& inputs) {
  if (!inputs.info().triangulation().empty()) return std::nullopt;
  return check_files(shop, inputs.info().inputs(), inputs.info().recursive());
}

Reply<JobDone> info(const Workshop& shop, const JobWork& work) {
  auto text = describe_inputs(shop, work.job.inputs().info(), work.ledger.token());
  if (!text) return problem_of(text.error());
  return JobDone{std::move(text).value(), 0, {}};
}

}  // namespace

constinit const Process info_process{
    .name = "info",
    .title = "Info",
    .description =
        "Describes input files or a result. The answer comes at once, unless Prefer: respond-async makes it a job.",
    .outcome = "The description of the files or of the result",
    .reads = Process::Reads::perhaps_a_result,
    .waits = true,
    .check_options = check_info_options,
    .check = check_info,
    .run = info};

}  // namespace tessera::service
