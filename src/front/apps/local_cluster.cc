#include "src/front/apps/local_cluster.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/process.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/cluster/certs/certificates.h"
#include "src/service/client/address.h"

namespace tessera::apps {
namespace fs = std::filesystem;
namespace {

constexpr const char* host = "127.0.0.1";
constexpr const char* program = "tesserad";

// Returns `count` different free ports. All sockets stay open until the last port is known.
Result<std::vector<std::uint16_t>> free_ports(std::size_t count) {
  const auto failed = [] { return error(Errc::io, "no port is free: " + std::generic_category().message(errno)); };
  std::vector<FileHandle> held;
  std::vector<std::uint16_t> ports;
  while (ports.size() < count) {
    FileHandle& one = held.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (one.get() < 0 || ::bind(one.get(), any, size) != 0 || ::getsockname(one.get(), any, &size) != 0)
      return failed();
    ports.push_back(ntohs(address.sin_port));
  }
  return ports;
}

// Returns the path of tesserad: beside this program if it is there, else in PATH.
Result<fs::path> find_daemon() {
  std::vector<fs::path> folders;
  std::error_code failed;
  if (const auto self = fs::read_symlink("/proc/self/exe", failed); !failed) folders.push_back(self.parent_path());
  const char* const path = std::getenv("PATH");
  std::istringstream names(path ? path : "");
  for (std::string name; std::getline(names, name, ':');) folders.emplace_back(name.empty() ? "." : name);
  for (const fs::path& folder : folders) {
    if (::access((folder / program).c_str(), X_OK) == 0) return folder / program;
  }
  return error(Errc::io, std::string(program) + ": the program is neither in the folder of this one nor in PATH");
}

std::string address_of(const LocalNode& node) { return std::string(host) + ":" + std::to_string(node.port); }

std::vector<std::string> arguments_of(const LocalCluster& cluster, const LocalNode& node) {
  std::vector<std::string> words{"--data",      local_data_folder(cluster.folder).string(),
                                 "--certs",     local_certificates_folder(cluster.folder).string(),
                                 "--cluster",   address_of(node),
                                 "--memory",    std::to_string(cluster.memory_bytes),
                                 "--threads",   std::to_string(cluster.threads),
                                 "--node-name", node.name,
                                 "--metrics",   "none"};
  const auto add = [&](std::vector<std::string> more) { words.insert(words.end(), more.begin(), more.end()); };
  if (&node != &cluster.nodes.front()) {
    // A node without a coordinator that could take its tiles ends after this time, before `tessera cluster down` kills
    // it.
    add({"--join", address_of(cluster.nodes.front()), "--drain-timeout", "10s"});
    return words;
  }
  add({"--listen", std::string(host) + ":" + std::to_string(cluster.api), "--uploads", "--print-token"});
  std::string inputs;
  for (const std::string& folder : cluster.inputs) inputs += (inputs.empty() ? "" : ",") + folder;
  if (!inputs.empty()) add({"--inputs", inputs});
  return words;
}

// Returns the line that the daemon prints when it answers. If the daemon ends before, returns what it has printed.
Result<std::string> first_line(const FileHandle& output) {
  std::string line;
  char c = 0;
  while (true) {
    const auto read = ::read(output.get(), &c, 1);
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) return io_error(program, "its output cannot be read", errno);
    if (read == 0 || c == '\n') return line;
    line += c;
  }
}

}  // namespace

fs::path LocalCluster::log_of(const LocalNode& node) const { return local_log_file(folder, node.name); }

Result<LocalCluster> new_local_cluster(const fs::path& folder, std::uint32_t nodes) {
  BOOST_OUTCOME_TRYV(find_daemon());  // fails before anything is made
  LocalCluster cluster;
  cluster.folder = folder;
  BOOST_OUTCOME_TRY(ports, free_ports(nodes + 1));
  cluster.api = ports.back();
  const fs::path certs = local_certificates_folder(folder);
  BOOST_OUTCOME_TRY(authority, is_there(authority_file(certs)));
  if (!authority) {
    BOOST_OUTCOME_TRYV(make_authority(certs));
  }
  for (std::uint32_t i = 0; i < nodes; ++i) {
    LocalNode node;
    node.name = "node-" + std::to_string(i + 1);
    node.port = ports[i];
    BOOST_OUTCOME_TRY(certificate, is_there(node_certificate_file(certs, node.name)));
    if (!certificate) {
      BOOST_OUTCOME_TRYV(make_node(certs, node.name));
    }
    cluster.nodes.push_back(std::move(node));
  }
  BOOST_OUTCOME_TRYV(make_directories(local_logs_folder(folder)));
  return cluster;
}

Result<std::optional<LocalCluster>> read_local_cluster(const fs::path& folder) {
  const fs::path file = local_cluster_file(folder);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return std::optional<LocalCluster>();
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  LocalCluster cluster;
  cluster.folder = folder;
  try {
    const auto json = parse_json(as_text(bytes));
    cluster.boot = json.at("boot").get<std::string>();
    cluster.api = json.at("api").get<std::uint16_t>();
    cluster.memory_bytes = json.at("memory_bytes").get<std::uint64_t>();
    cluster.threads = json.at("threads").get<std::uint32_t>();
    cluster.inputs = json.at("inputs").get<std::vector<std::string>>();
    for (const auto& entry : json.at("nodes")) {
      LocalNode& node = cluster.nodes.emplace_back();
      node.name = entry.at("name").get<std::string>();
      node.port = entry.at("port").get<std::uint16_t>();
      node.process.number = entry.at("pid").get<pid_t>();
      node.process.started = entry.at("started").get<std::uint64_t>();
    }
  } catch (const nlohmann::json::exception& wrong) {
    return error(Errc::corrupt, file.string() + ": " + wrong.what());
  }
  if (cluster.nodes.empty()) return error(Errc::corrupt, file.string() + ": has no nodes");
  return std::optional(std::move(cluster));
}

Status write_local_cluster(const LocalCluster& cluster) {
  nlohmann::ordered_json json{
      {"boot", cluster.boot},       {"api", cluster.api},       {"memory_bytes", cluster.memory_bytes},
      {"threads", cluster.threads}, {"inputs", cluster.inputs}, {"nodes", nlohmann::ordered_json::array()}};
  for (const LocalNode& node : cluster.nodes) {
    json["nodes"].push_back({{"name", node.name},
                             {"port", node.port},
                             {"pid", node.process.number},
                             {"started", node.process.started},
                             {"log", cluster.log_of(node).string()}});
  }
  return write_whole(local_cluster_file(cluster.folder), json_text(json, 2) + "\n");
}

Result<std::optional<RunningProcess>> process_of(const LocalCluster& cluster, const LocalNode& node) {
  if (cluster.boot != boot_id()) return std::optional<RunningProcess>();
  return RunningProcess::find(node.process);
}

Status start_node(LocalCluster& cluster, LocalNode& node) {
  BOOST_OUTCOME_TRY(daemon, find_daemon());
  const bool first = &node == &cluster.nodes.front();
  BOOST_OUTCOME_TRY(started, start_process(daemon, arguments_of(cluster, node), cluster.log_of(node), "TESSERAD_"));
  if (cluster.boot != boot_id()) {  // the machine has restarted, so the other numbers mean nothing any more
    for (LocalNode& other : cluster.nodes) other.process = {};
    cluster.boot = boot_id();
  }
  node.process = started.id;
  BOOST_OUTCOME_TRYV(write_local_cluster(cluster));
  if (!first) return success();
  BOOST_OUTCOME_TRY(line, first_line(started.output));
  const auto address = client::parse_address(line);
  if (!address) return error(Errc::io, node.name + " has ended: " + last_words(cluster, node));
  return write_private(local_token_file(cluster.folder), std::as_bytes(std::span(address.value().token)));
}

std::string last_words(const LocalCluster& cluster, const LocalNode& node) {
  const auto bytes = read_whole(cluster.log_of(node));
  if (!bytes) return {};
  std::string_view text = as_text(bytes.value());
  while (text.ends_with('\n')) text.remove_suffix(1);
  return std::string(text.substr(text.rfind('\n') + 1));
}

}  // namespace tessera::apps
