#include "src/front/daemon/cluster_settings.h"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/cluster/certs/certificates.h"
#include "src/front/daemon/add_option.h"
#include "src/front/daemon/daemon_options.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"

namespace tessera::daemon {
namespace {

Result<std::vector<HostPort>> parse_addresses(const std::string& text) {
  BOOST_OUTCOME_TRY(names, parse_names(text));
  std::vector<HostPort> addresses;
  for (const std::string& name : names) {
    BOOST_OUTCOME_TRY(address, parse_host_port(name));
    addresses.push_back(std::move(address));
  }
  return addresses;
}

Status read_roles(const std::string& text, ClusterOptions& out) {
  BOOST_OUTCOME_TRY(roles, parse_names(text));
  out.coordinator = out.node = false;
  for (const std::string& role : roles) {
    if (role != "coordinator" && role != "node")
      return error(Errc::usage, "roles: '" + role + "' is neither coordinator nor node");
    (role == "node" ? out.node : out.coordinator) = true;
  }
  return success();
}

}  // namespace

void add_cluster_options(CLI::App& app, apps::Settings& settings) {
  add_option(app, settings, "cluster", "HOST:PORT",
             "the address at which this process of a cluster listens for the others");
  add_option(app, settings, "advertise", "HOST:PORT",
             "the address at which the others reach this process; default: that of --cluster");
  add_option(app, settings, "join", "HOST:PORT,...",
             "the addresses of some processes of the cluster; default: none, this process is the first");
  add_option(app, settings, "certs", "DIR",
             "the folder with the certificate and key of this process, and the certificate of the cluster's authority "
             "(see 'tessera certs')");
  add_option(app, settings, "roles", "ROLE,...",
             "coordinator (takes jobs), node (works on them); default: both, or node with --join");
  add_option(app, settings, "node-name", "NAME", "the name of this node, for people; default: the host's name");
  add_option(app, settings, "cluster-name", "NAME",
             "the name of the cluster; processes of other clusters are refused; default: tessera");
  add_option(app, settings, "scratch", "DIR",
             "a folder on a disk of this machine, for tiles that are not in memory; default: in the data folder");
  add_option(app, settings, "lease", "TIME", "how long a node may be silent before it is lost; default: 10s");
  add_option(app, settings, "grace", "TIME", "how long nodes keep their tiles without a coordinator; default: 5m");
  add_option(app, settings, "drain-timeout", "TIME",
             "how long a node that is told to end may take to hand over its tiles; default: 20s");
}

Result<std::optional<ClusterOptions>> read_cluster_options(const apps::Settings& settings,
                                                           const std::filesystem::path& data) {
  const auto text = [](const std::string& t) -> Result<std::string> { return t; };
  BOOST_OUTCOME_TRY(listen, settings.get("cluster", parse_host_port));
  BOOST_OUTCOME_TRY(advertise, settings.get("advertise", parse_host_port));
  BOOST_OUTCOME_TRY(join, settings.get("join", parse_addresses));
  BOOST_OUTCOME_TRY(certs, settings.get("certs", text));
  BOOST_OUTCOME_TRY(roles, settings.get("roles", text));
  BOOST_OUTCOME_TRY(node_name, settings.get("node-name", text));
  BOOST_OUTCOME_TRY(name, settings.get("cluster-name", text));
  BOOST_OUTCOME_TRY(scratch, settings.get("scratch", text));
  BOOST_OUTCOME_TRY(lease, settings.get("lease", parse_duration));
  BOOST_OUTCOME_TRY(grace, settings.get("grace", parse_duration));
  BOOST_OUTCOME_TRY(drain_timeout, settings.get("drain-timeout", parse_duration));
  if (!listen) {
    if (join || certs || roles)
      return error(Errc::usage,
                   "--cluster HOST:PORT is needed: the address at which this process listens for the others");
    return std::optional<ClusterOptions>();
  }
  if (!certs)
    return error(Errc::usage,
                 "--certs DIR is needed: nodes know each other by their certificates, which 'tessera certs' makes");
  ClusterOptions out;
  out.listen = *listen;
  out.advertised = advertise.value_or(*listen);
  out.join = join.value_or(std::vector<HostPort>{});
  out.coordinator = out.join.empty();
  if (roles) {
    BOOST_OUTCOME_TRYV(read_roles(*roles, out));
  }
  if (!out.coordinator && out.join.empty())
    return error(Errc::usage,
                 "--join HOST:PORT is needed: the address of a process of the cluster that this node joins");
  out.node_name = node_name.value_or(host_name());
  out.name = name.value_or(out.name);
  if (lease && *lease > 0) out.lease = std::chrono::seconds(*lease);
  if (grace) out.grace_s = static_cast<std::uint32_t>(*grace);
  if (drain_timeout) out.drain_timeout = std::chrono::seconds(*drain_timeout);
  BOOST_OUTCOME_TRY(files, node_name ? node_certificate_in(*certs, *node_name) : node_certificate_in(*certs));
  BOOST_OUTCOME_TRYV(check_node(files));
  BOOST_OUTCOME_TRY(end, valid_until(files.certificate));
  out.certificate_end_s =
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::seconds>(end.time_since_epoch()).count());
  out.authority = files.authority;
  out.certificate = files.certificate;
  out.key = files.key;
  out.scratch = scratch ? std::filesystem::path(*scratch) : node_scratch_folder(data, out.node_name);
  return std::optional(std::move(out));
}

}  // namespace tessera::daemon
