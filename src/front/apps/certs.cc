// tessera certs: makes the certificate authority of a cluster, and certificates of its nodes.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "src/base/files/names.h"
#include "src/cluster/certs/certificates.h"
#include "src/front/apps/command.h"
#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/arguments.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string action, folder;
  std::vector<std::string> nodes;
};

constexpr const char* help = "try 'tessera certs --help'";

Status make_cluster(const fs::path& folder, const CertificateOptions& options, const OutputOptions& output) {
  BOOST_OUTCOME_TRYV(make_authority(folder, options));
  const fs::path file = authority_file(folder), key = authority_key_file(folder);
  BOOST_OUTCOME_TRY(until, valid_until(file));
  if (output.json) {
    print_json_line({{"event", "authority"},
                     {"cluster", options.cluster},
                     {"authority", file.string()},
                     {"key", key.string()},
                     {"valid_until", date_text(until)}});
  } else if (!output.quiet) {
    say("%s: the authority of the cluster %s, valid until %s\n", file.c_str(), options.cluster.c_str(),
        date_text(until).c_str());
    say("%s: the key of the authority; anyone who has it can add nodes to the cluster: keep it secret\n", key.c_str());
    say("next: tessera certs node %s NAME ...\n", folder.c_str());
  }
  return success();
}

Status make_nodes(const fs::path& folder, const std::vector<std::string>& nodes, const CertificateOptions& options,
                  const OutputOptions& output) {
  std::set<std::string> different;
  for (const auto& node : nodes) {
    BOOST_OUTCOME_TRYV(check_node_name(node));
    if (!different.insert(node).second) return error(Errc::usage, "the node '" + node + "' is given twice");
  }
  for (const auto& node : nodes) {
    BOOST_OUTCOME_TRYV(make_node(folder, node, options));
    const fs::path file = node_certificate_file(folder, node), key = node_key_file(folder, node);
    BOOST_OUTCOME_TRY(until, valid_until(file));
    if (output.json) {
      print_json_line({{"event", "node"},
                       {"node", node},
                       {"authority", authority_file(folder).string()},
                       {"certificate", file.string()},
                       {"key", key.string()},
                       {"valid_until", date_text(until)}});
    } else if (!output.quiet) {
      say("%s, %s: the node %s, valid until %s\n", file.c_str(), key.c_str(), node.c_str(), date_text(until).c_str());
    }
  }
  if (!output.json && !output.quiet)
    say("copy %s and the two files of each node to a folder on that node; %s stays here\n",
        authority_file(folder).c_str(), authority_key_file(folder).c_str());
  return success();
}

Status run_certs(Settings& settings, const Arguments& arguments) {
  const bool init = arguments.action == "init";
  if (arguments.action.empty()) return error(Errc::usage, std::string("no action is given (init or node); ") + help);
  if (!init && arguments.action != "node")
    return error(Errc::usage, "'" + arguments.action + "' is not an action; the actions are init and node");
  if (arguments.folder.empty()) return error(Errc::usage, std::string("no folder of certificates is given; ") + help);
  if (init && !arguments.nodes.empty())
    return error(Errc::usage,
                 "init makes no certificates of nodes; 'tessera certs node' makes them, and --name names the cluster");
  if (!init && arguments.nodes.empty()) return error(Errc::usage, std::string("no name of a node is given; ") + help);
  CertificateOptions options;
  BOOST_OUTCOME_TRY(days, settings.get("days", [](const std::string& text) { return parse_integer(text, 1, 36500); }));
  if (days) options.days = static_cast<int>(*days);
  const auto name = settings.text("name");
  if (name && !init) return error(Errc::usage, "--name: the name of the cluster is given to 'tessera certs init' only");
  if (name) options.cluster = *name;
  BOOST_OUTCOME_TRY(output, output_options(settings));
  return init ? make_cluster(arguments.folder, options, output)
              : make_nodes(arguments.folder, arguments.nodes, options, output);
}

}  // namespace

Command add_certs(CLI::App& root) {
  auto command = new_command(
      root, "certs", "Makes the certificates by which the nodes of a cluster know each other",
      "  tessera certs init certs                    ca.pem and ca.key: the authority of a cluster\n"
      "  tessera certs init certs --name lyon --days 1000\n"
      "  tessera certs node certs alpha beta         alpha.pem, alpha.key, beta.pem, beta.key\n\n"
      "Copy ca.pem, alpha.pem and alpha.key to the node alpha, into a folder that only its daemon can read.\n"
      "ca.key stays here: anyone who has it can add nodes. Nodes trust every certificate of their authority,\n"
      "whatever its name, so each cluster needs an authority of its own. Existing files are never replaced.");
  add_value(command, "days", "N",
            "how many days the certificate is valid; default: 3650 for init, 730 for node; the certificate of a node "
            "never outlives its authority",
            0, true);
  add_value(command, "name", "CLUSTER", "init: the name of the cluster, in its certificate; default: tessera", 0, true);
  add_switch(command, "quiet", "print errors only");
  add_switch(command, "json", "one JSON object a line on stdout, instead of text");
  auto arguments = std::make_shared<Arguments>();
  add_argument(command, "action", "init|node", arguments->action,
               "init makes an authority; node makes certificates of nodes");
  add_choices(command, "action", "init, node");
  add_argument(command, "folder", "DIR", arguments->folder, "the folder of the authority; init makes it");
  add_argument(command, "names", "NAME", arguments->nodes,
               "node: the names of the nodes, for example node-1 or 10.0.0.7");
  command.run = [settings = command.settings.get(), arguments](const std::vector<std::string>&) {
    return run_certs(*settings, *arguments);
  };
  return command;
}

}  // namespace tessera::apps
