#include "src/front/apps/watching.h"

#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/phases.h"
#include "src/base/progress.h"
#include "src/front/apps/drawn.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/job_text.h"
#include "src/front/apps/log.h"
#include "src/front/apps/outcome.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/describe.h"
#include "src/job/job_report.h"
#include "src/job/report/progress_display.h"
#include "src/job/report/summary.h"
#include "src/service/client/fetch.h"
#include "src/service/client/messages.h"

namespace tessera::apps {
namespace {

void set_progress(const proto::StatusInfo& job, Progress& progress) {
  if (const auto phase = phase_named(job.phase())) progress.phase = *phase;
  if (!job.has_figures()) return;
  const auto& figures = job.figures();
  progress.points_total = figures.points_total();
  progress.points_routed = figures.points_routed();
  progress.points_triangulated = figures.points_triangulated();
  progress.tiles_total = figures.tiles_total();
  progress.tiles_triangulated = figures.tiles_triangulated();
  progress.tiles_stored = figures.tiles_stored();
  progress.tiles_asleep = figures.tiles_asleep();
  progress.updates_sent = figures.updates_sent();
  progress.updates_processed = figures.updates_processed();
  progress.points_sent = figures.points_sent();
  progress.memory_bytes = figures.memory_bytes();
  progress.bytes_between = figures.bytes_between();
  progress.credit_waits = figures.credit_waits();
  std::vector<NodeProgress> nodes;
  for (const auto& node : figures.nodes()) {
    nodes.push_back(
        {node.name(), node.tiles(), node.tiles_triangulated(), node.tiles_stored(), node.memory_bytes(), node.lost()});
  }
  progress.set_nodes(std::move(nodes));
}

class Watch {
 public:
  explicit Watch(const OutputOptions& output) : output_(output) {}

  // Shows an event. Returns true if the job has ended.
  Result<bool> take(const proto::Event& event) {
    if (event.kind() == "log") log_debug(event.text());
    if (!event.has_status()) return false;
    const auto& job = event.status();
    set_progress(job, progress_);
    if (job.status() == "running" && !display_)
      display_.emplace(progress_, progress_style(output_), output_.json ? stdout : stderr, job.figures().elapsed_s());
    if (job.status() != "running") display_.reset();
    if (job.status() != last_.status()) tell_status(job);
    last_ = job;
    return has_ended(job);
  }
  // Removes the panel from the terminal, so that other text can be printed.
  void pause() { display_.reset(); }
  const proto::StatusInfo& last() const { return last_; }

 private:
  void tell_status(const proto::StatusInfo& job) const {
    if (output_.json) {
      print_json_line(job_json(job));
      std::fflush(stdout);
    } else if (!output_.quiet && job.status() == "accepted") {
      say_beside("job %s is accepted\n", job.job_id().c_str());
    }
  }

  const OutputOptions& output_;
  Progress progress_;
  std::optional<ProgressDisplay> display_;
  proto::StatusInfo last_;
};

Status show_summary(client::Server& server, const proto::StatusInfo& job, const OutputOptions& output,
                    const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(manifest, client::fetch_manifest(server, job.triangulation(), stop));
  const auto summary = summary_of(manifest, job.triangulation());
  say_whole(output.json ? summary_json(summary) + "\n" : summary_text(summary), output.json);
  return success();
}

Status show_outcome(client::Server& server, const proto::StatusInfo& job, const OutputOptions& output,
                    const std::stop_token& stop) {
  if (output.quiet) return success();
  if (job.process_id() == "triangulate") return show_summary(server, job, output, stop);
  BOOST_OUTCOME_TRY(outcome, server.outcome(job.job_id(), stop));
  if (output.json) {
    print_json_line(outcome);
    return success();
  }
  if (print_drawn(outcome, output)) return success();
  const auto verified = verified_of(outcome);
  const auto exported = exported_of(outcome);
  const auto heights = heights_of(outcome);
  const auto measured = measured_of(outcome);
  const auto described = description_text(outcome, false);
  if (verified) {
    print_verified(job.triangulation(), *verified, output);
  } else if (exported) {
    print_exported(*exported, "", output);
  } else if (heights) {
    print_heights(job.triangulation(), *heights, std::nullopt, output);
  } else if (measured) {
    print_measured(*measured, output);
  } else if (is_updated(outcome)) {
    print_updated(outcome, output);
  } else if (described) {
    say_whole(*described, false);
  } else {
    say("job %s: %s%s\n", job.job_id().c_str(), job.status().c_str(),
        job.message().empty() ? "" : (": " + job.message()).c_str());
  }
  return success();
}

Error problem_of(const proto::StatusInfo& job) {
  const int cause = job.problem().cause();
  const bool known = cause >= static_cast<int>(Errc::usage) && cause <= static_cast<int>(Errc::internal);
  const auto& said = job.problem().detail().empty() ? job.message() : client::sentence_of(job.problem());
  return error(known ? static_cast<Errc>(cause) : Errc::internal,
               said.empty() ? "job " + job.job_id() + " has failed, and the daemon does not say why" : said);
}

}  // namespace

std::string command_for(const Settings& settings, const std::string& verb, const std::string& id) {
  std::string text = "tessera " + verb + " " + id;
  if (settings.source("server") == Settings::Source::flag) {
    const auto address = client::parse_address(settings.text("server").value_or(""));
    if (address) text += " --server " + address.value().text();  // this text has no token
  }
  return "'" + text + "'";
}

ProgressStyle progress_style(const OutputOptions& output) {
  if (output.quiet) return ProgressStyle::none;
  if (output.json) return ProgressStyle::json;
  // Log lines would break the panel into pieces.
  return isatty(STDERR_FILENO) != 0 && !output.verbose ? ProgressStyle::terminal : ProgressStyle::lines;
}

void print_detached(const Settings& settings, const proto::StatusInfo& job, const OutputOptions& output) {
  if (output.json) {
    print_json_line(job_json(job));
  } else if (output.quiet) {
    say("%s\n", job.job_id().c_str());
  } else {
    say("job %s is %s; %s shows it, %s stops it\n", job.job_id().c_str(), job.status().c_str(),
        command_for(settings, "watch", job.job_id()).c_str(), command_for(settings, "cancel", job.job_id()).c_str());
  }
}

Result<proto::StatusInfo> await_job(client::Server& server, const Settings& settings, const std::string& id,
                                    const OutputOptions& output, const std::stop_token& stop) {
  Watch watch(output);
  const auto on_gone = [&](const std::string& why) {
    watch.pause();
    if (!output.quiet) say_beside("%s; waiting until the daemon answers again\n", why.c_str());
  };
  const auto watched = server.events(
      id, [&](const proto::Event& event) { return watch.take(event); }, on_gone, stop);
  watch.pause();
  if (!watched) {
    if (watched.error().code == Errc::io && !watch.last().job_id().empty()) {
      return error(Errc::io, watched.error().where + "; the job continues when the daemon runs again: " +
                                 command_for(settings, "watch", id) + " shows it again");
    }
    if (watched.error().code != Errc::interrupted) return watched.error();
    return error(Errc::interrupted, "detached; the job continues: " + command_for(settings, "watch", id) +
                                        " shows it again, " + command_for(settings, "cancel", id) + " stops it");
  }
  const auto& job = watch.last();
  if (job.status() == "successful") return job;
  if (job.status() == "dismissed") {
    return error(Errc::interrupted,
                 "job " + id + " was cancelled" +
                     (job.resumable() ? "; " + command_for(settings, "resume", id) + " continues it" : ""));
  }
  return problem_of(job);
}

Status watch_job(client::Server& server, const Settings& settings, const std::string& id, const OutputOptions& output) {
  const Interrupt interrupt;
  BOOST_OUTCOME_TRY(job, await_job(server, settings, id, output, interrupt.token()));
  return show_outcome(server, job, output, interrupt.token());
}

}  // namespace tessera::apps
