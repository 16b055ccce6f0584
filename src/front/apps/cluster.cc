// tessera cluster: runs several daemons on this machine as one cluster, for trials and tests.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/front/apps/command.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/job_text.h"
#include "src/front/apps/local_cluster.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds join_time{60}, end_time{20};
constexpr std::chrono::milliseconds pause{50};  // between two requests to the coordinator
constexpr std::int64_t nodes_max = 64, usual_nodes = 4;
constexpr std::uint64_t memory_min = std::uint64_t{64} << 20;

struct ClusterArguments {
  std::string action, folder, node;
};

using Nodes = std::vector<proto::NodeInfo>;

Result<LocalCluster> existing(const fs::path& folder) {
  BOOST_OUTCOME_TRY(found, read_local_cluster(folder));
  if (!found)
    return error(Errc::usage, folder.string() + ": there is no cluster in this folder; 'tessera cluster up' makes one");
  return *std::move(found);
}

Result<client::Server> server_of(const LocalCluster& cluster) {
  client::ServerOptions options;
  BOOST_OUTCOME_TRY(address, client::parse_address(cluster.url()));
  options.address = std::move(address);
  BOOST_OUTCOME_TRY(token, read_whole(local_token_file(cluster.folder)));
  options.token = std::string(as_text(token));
  options.patience = 0s;
  return client::Server::make(std::move(options));
}

// Waits until `so` is true of the nodes. Errors: io, also if the process of a node in `alive` ends, and after a minute;
// interrupted.
Status wait_until(const LocalCluster& cluster, client::Server& server, const std::function<bool(const Nodes&)>& so,
                  const std::vector<const LocalNode*>& alive, const std::stop_token& stop) {
  const auto until = Clock::now() + join_time;
  while (true) {
    BOOST_OUTCOME_TRY(nodes, server.nodes(stop));
    if (so(nodes)) return success();
    for (const LocalNode* node : alive) {
      BOOST_OUTCOME_TRY(process, process_of(cluster, *node));
      if (!process) return error(Errc::io, node->name + " has ended: " + last_words(cluster, *node));
    }
    if (stop.stop_requested())
      return error(Errc::interrupted, "interrupted; 'tessera cluster down' ends the processes that run");
    if (Clock::now() > until)
      return error(Errc::io, "not all nodes have joined in a minute; their logs are in " +
                                 local_logs_folder(cluster.folder).string());
    std::this_thread::sleep_for(pause);
  }
}

bool has(const Nodes& nodes, const std::string& name, bool free) {
  return std::any_of(nodes.begin(), nodes.end(), [&](const proto::NodeInfo& node) {
    return node.name() == name && (!free || node.state() == "free");
  });
}

struct Given {
  std::optional<std::int64_t> nodes, threads;
  std::optional<std::uint64_t> memory_bytes;
  std::optional<std::vector<std::string>> inputs;
};

Result<Given> read_given(Settings& settings) {
  BOOST_OUTCOME_TRY(nodes,
                    settings.get("nodes", [](const std::string& text) { return parse_integer(text, 1, nodes_max); }));
  BOOST_OUTCOME_TRY(memory, settings.get("memory", [](const std::string& text) { return parse_memory(text); }));
  BOOST_OUTCOME_TRY(threads,
                    settings.get("threads", [](const std::string& text) { return parse_integer(text, 1, 1024); }));
  BOOST_OUTCOME_TRY(inputs, settings.get("inputs", [](const std::string& text) { return parse_names(text); }));
  if (memory && *memory < memory_min) return error(Errc::usage, "--memory: a node needs at least 64M");
  return Given{nodes, threads, memory, std::move(inputs)};
}

// Sets the members that the user gave. The others keep their values; in a new cluster they get defaults.
void configure(LocalCluster& cluster, const Given& given, bool fresh) {
  const std::size_t count = cluster.nodes.size();
  if (fresh) {
    cluster.memory_bytes = std::max<std::uint64_t>(memory_min, default_memory() / count);
    cluster.threads = std::max<std::uint32_t>(1, usable_processors() / static_cast<std::uint32_t>(count));
    cluster.inputs = {fs::current_path().string()};
  }
  if (given.memory_bytes) cluster.memory_bytes = *given.memory_bytes;
  if (given.threads) cluster.threads = static_cast<std::uint32_t>(*given.threads);
  if (given.inputs) {
    cluster.inputs.clear();
    for (const std::string& folder : *given.inputs) cluster.inputs.push_back(fs::absolute(folder).string());
  }
}

// Starts the nodes that do not run, and returns when all nodes are free for work.
Status start_missing(LocalCluster& cluster, const std::stop_token& stop) {
  std::vector<LocalNode*> missing;
  std::vector<const LocalNode*> all, alive;
  for (LocalNode& node : cluster.nodes) {
    BOOST_OUTCOME_TRY(process, process_of(cluster, node));
    if (!process) missing.push_back(&node);
    if (process) alive.push_back(&node);
    all.push_back(&node);
  }
  const bool coordinator_runs = missing.empty() || missing.front() != &cluster.nodes.front();
  if (!missing.empty() && coordinator_runs) {  // wait until it has forgotten the old processes of these nodes
    BOOST_OUTCOME_TRY(server, server_of(cluster));
    const auto forgotten = [&](const Nodes& nodes) {
      return std::none_of(missing.begin(), missing.end(),
                          [&](const LocalNode* node) { return has(nodes, node->name, false); });
    };
    BOOST_OUTCOME_TRYV(wait_until(cluster, server, forgotten, alive, stop));
  }
  for (LocalNode* node : missing) {
    BOOST_OUTCOME_TRYV(start_node(cluster, *node));
  }
  BOOST_OUTCOME_TRY(server, server_of(cluster));
  const auto complete = [&](const Nodes& nodes) {
    return std::all_of(all.begin(), all.end(), [&](const LocalNode* node) { return has(nodes, node->name, true); });
  };
  return wait_until(cluster, server, complete, all, stop);
}

Status run_up(Settings& settings, const fs::path& folder, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(given, read_given(settings));
  BOOST_OUTCOME_TRYV(make_directories(folder));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(folder));
  [[maybe_unused]] const FolderLock ours = std::move(lock);
  BOOST_OUTCOME_TRY(found, read_local_cluster(folder));
  const bool fresh = !found;
  if (fresh) {
    BOOST_OUTCOME_TRY(made, new_local_cluster(folder, static_cast<std::uint32_t>(given.nodes.value_or(usual_nodes))));
    found = std::move(made);
  }
  LocalCluster& cluster = *found;
  if (given.nodes && static_cast<std::size_t>(*given.nodes) != cluster.nodes.size()) {
    return error(Errc::usage, folder.string() + ": holds a cluster of " + std::to_string(cluster.nodes.size()) +
                                  " nodes already; give another folder for a cluster of " +
                                  std::to_string(*given.nodes));
  }
  configure(cluster, given, fresh);
  BOOST_OUTCOME_TRYV(write_local_cluster(cluster));
  const Interrupt interrupt;
  BOOST_OUTCOME_TRYV(start_missing(cluster, interrupt.token()));
  const std::string token = local_token_file(folder).string();
  if (output.json) {
    print_json_line({{"event", "cluster"},
                     {"url", cluster.url()},
                     {"token_file", token},
                     {"nodes", cluster.nodes.size()},
                     {"logs", local_logs_folder(folder).string()}});
  } else if (!output.quiet) {
    say("%zu nodes are ready at %s; their logs: %s\n", cluster.nodes.size(), cluster.url().c_str(),
        local_logs_folder(folder).c_str());
    say("next:\n  export TESSERA_SERVER=%s TESSERA_TOKEN_FILE='%s'\n", cluster.url().c_str(), token.c_str());
    say("  tessera triangulate '*.las' -o block     files below %s\n",
        cluster.inputs.empty() ? "no folder" : cluster.inputs.front().c_str());
    say("  tessera cluster kill '%s' %zu; tessera cluster down '%s'\n", folder.c_str(), cluster.nodes.size(),
        folder.c_str());
  }
  return success();
}

Status run_status(const fs::path& folder, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(cluster, existing(folder));
  const Interrupt interrupt;
  Nodes nodes;
  std::string trouble;
  BOOST_OUTCOME_TRY(coordinator, process_of(cluster, cluster.nodes.front()));
  if (coordinator) {
    auto server = server_of(cluster);
    auto told = server ? server.value().nodes(interrupt.token()) : Result<Nodes>(server.error());
    if (told) {
      nodes = std::move(told).value();
    } else {
      trouble = told.error().where;
    }
  }
  std::vector<LocalNodeState> states;
  for (const LocalNode& node : cluster.nodes) {
    BOOST_OUTCOME_TRY(process, process_of(cluster, node));
    LocalNodeState& state = states.emplace_back();
    state.log = cluster.log_of(node).string();
    if (process) state.process = node.process.number;
    const auto member =
        std::find_if(nodes.begin(), nodes.end(), [&](const proto::NodeInfo& info) { return info.name() == node.name; });
    if (member != nodes.end()) state.info = *member;
    state.info.set_name(node.name);
  }
  if (output.json) {
    for (const LocalNodeState& state : states) print_json_line(local_node_json(state));
  } else if (!output.quiet) {
    say("%s", local_nodes_text(states).c_str());
    say("%s\n", cluster.url().c_str());
  }
  if (!trouble.empty()) return error(Errc::io, "the coordinator of the cluster runs, but does not answer: " + trouble);
  return success();
}

Status run_kill(const fs::path& folder, const std::string& number, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(cluster, existing(folder));
  const auto at = parse_integer(number, 1, static_cast<std::int64_t>(cluster.nodes.size()));
  if (!at) return error(Errc::usage, "node " + at.error().where);
  BOOST_OUTCOME_TRY(lock, FolderLock::take(folder));
  [[maybe_unused]] const FolderLock ours = std::move(lock);
  const LocalNode& node = cluster.nodes[static_cast<std::size_t>(at.value() - 1)];
  BOOST_OUTCOME_TRY(process, process_of(cluster, node));
  if (!process) return error(Errc::usage, node.name + " does not run; 'tessera cluster up' starts it");
  BOOST_OUTCOME_TRYV(process->signal(SIGKILL));
  if (!process->ends_within(end_time)) return error(Errc::io, node.name + " cannot be killed");
  if (output.json) {
    print_json_line({{"event", "killed"}, {"name", node.name}, {"pid", node.process.number}});
  } else if (!output.quiet) {
    say("%s, process %d, was killed; 'tessera cluster up %s' starts it again\n", node.name.c_str(),
        static_cast<int>(node.process.number), folder.c_str());
  }
  return success();
}

// Ends all processes, the coordinator first: while its nodes still run, its jobs can stop so that they can be resumed.
Status run_down(const fs::path& folder, const OutputOptions& output) {
  BOOST_OUTCOME_TRY(cluster, existing(folder));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(folder));
  [[maybe_unused]] const FolderLock ours = std::move(lock);
  const auto until = Clock::now() + end_time;
  const auto left = [&] { return std::max(0ms, std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now())); };
  std::vector<RunningProcess> others;
  std::size_t killed = 0;
  const auto await = [&](const RunningProcess& process) -> Status {
    if (process.ends_within(left())) return success();
    ++killed;
    BOOST_OUTCOME_TRYV(process.signal(SIGKILL));
    if (!process.ends_within(end_time)) return error(Errc::io, "a process of the cluster cannot be killed");
    return success();
  };
  std::size_t ended = 0;
  for (const LocalNode& node : cluster.nodes) {
    BOOST_OUTCOME_TRY(process, process_of(cluster, node));
    if (!process) continue;
    ++ended;
    BOOST_OUTCOME_TRYV(process->signal(SIGTERM));
    if (&node == &cluster.nodes.front()) {
      BOOST_OUTCOME_TRYV(await(*process));
    } else {
      others.push_back(*std::move(process));
    }
  }
  for (const RunningProcess& process : others) {
    BOOST_OUTCOME_TRYV(await(process));
  }
  if (output.json) {
    print_json_line({{"event", "down"}, {"ended", ended}, {"killed", killed}});
  } else if (!output.quiet) {
    say("%zu processes have ended%s; jobs and results stay in %s\n", ended,
        killed > 0 ? (", " + std::to_string(killed) + " of them killed").c_str() : "", folder.c_str());
  }
  return success();
}

Status run_cluster(Settings& settings, const ClusterArguments& arguments) {
  const std::string& action = arguments.action;
  if (action.empty()) return error(Errc::usage, "no action is given; try 'tessera cluster --help'");
  if (action != "up" && action != "status" && action != "kill" && action != "down")
    return error(Errc::usage, "'" + action + "' is not an action; the actions are up, status, kill and down");
  if (arguments.folder.empty()) return error(Errc::usage, "no folder is given; try 'tessera cluster --help'");
  if (action == "kill" && arguments.node.empty())
    return error(Errc::usage, "no node is given; add its number, as in 'tessera cluster kill DIR 2'");
  if (action != "kill" && !arguments.node.empty())
    return error(Errc::usage,
                 "'" + arguments.node + "' is one argument too many: only kill takes the number of a node");
  for (const char* key : {"nodes", "memory", "threads", "inputs"}) {
    if (action != "up" && settings.text(key))
      return error(Errc::usage, "--" + std::string(key) + ": only 'tessera cluster up' takes this option");
  }
  BOOST_OUTCOME_TRY(output, output_options(settings));
  const fs::path folder = fs::absolute(arguments.folder).lexically_normal();
  if (action == "up") return run_up(settings, folder, output);
  if (action == "status") return run_status(folder, output);
  if (action == "kill") return run_kill(folder, arguments.node, output);
  return run_down(folder, output);
}

}  // namespace

Command add_cluster(CLI::App& root) {
  auto command = new_command(
      root, "cluster", "Runs a cluster of daemons on this machine, to try clusters out",
      "  tessera cluster up -n 4 DIR       starts four daemons with certificates, and says what to type next\n"
      "  tessera cluster status DIR        shows the processes, and what the coordinator knows of them\n"
      "  tessera cluster kill DIR 2        kills node 2, as if its machine had died; up starts it again\n"
      "  tessera cluster down DIR          ends all daemons; jobs and results stay");
  add_value(command, "nodes", "N", "up: how many nodes; default: 4", 'n', true);
  add_value(command, "memory", "SIZE",
            "up: the memory of each node; default: an equal share of what one daemon would take", 0, true);
  add_value(command, "threads", "N", "up: the worker threads of each node; default: an equal share of the processors",
            0, true);
  add_value(command, "inputs", "DIR,...", "up: folders that jobs may read; default: the current folder", 0, true);
  add_switch(command, "quiet", "print errors only");
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  auto arguments = std::make_shared<ClusterArguments>();
  add_argument(command, "action", "up|status|kill|down", arguments->action, "what to do");
  add_choices(command, "action", "up, status, kill, down");
  add_argument(command, "folder", "DIR", arguments->folder, "the folder of the cluster; up makes it");
  add_argument(command, "node", "N", arguments->node, "kill: the number of a node; node 1 is the coordinator");
  command.run = [settings = command.settings.get(), arguments](const std::vector<std::string>&) {
    return run_cluster(*settings, *arguments);
  };
  return command;
}

}  // namespace tessera::apps
