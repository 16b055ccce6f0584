// The certificates by which the nodes of a cluster know each other. Each cluster has an authority of its own: the nodes
// do not compare names, so whoever holds a certificate that it has signed is one of them.
//
// Keys are EC P-256 without a passphrase, in files that their owner alone can read; all files are PEM. Their names are
// in src/base/files/names.h.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

struct CertificateOptions {
  // Of the authority alone: in its certificate, for people. Of the letters, and as long, as the name of a node.
  std::string cluster = "tessera";
  // How long it is valid, 1 to 36500 days. Default: 10 years of an authority, 2 of a node.
  std::optional<int> days;
  // When it is made. It is valid from an hour before, since clocks differ.
  std::chrono::system_clock::time_point now = std::chrono::system_clock::now();
};

// Error usage unless it can be the name of a node: 1 to 64 of A-Z, a-z, 0-9, '.', '_' and '-', the first a letter or
// digit; and not "ca".
Status check_node_name(const std::string& name);

// A new authority in `folder`, which is made for its owner alone when it is not there. Errors: usage, also when an
// authority is there, or others can write the folder; io.
Status make_authority(const std::filesystem::path& folder, const CertificateOptions& options = {});

// A node's certificate, signed by the authority in `folder`, and valid no longer than that one. Errors: usage, also
// when the node has one, the authority has expired, or others can read its key; io.
Status make_node(const std::filesystem::path& folder, const std::string& name, const CertificateOptions& options = {});

// The files of one node.
struct NodeCertificate {
  std::filesystem::path authority, certificate, key;
};

// Of the only node in `folder`, which holds what was copied to that node: ca.pem, NAME.pem and NAME.key. Error usage
// when there is none, or several; io. What is in the files is checked by check_node().
Result<NodeCertificate> node_certificate_in(const std::filesystem::path& folder);
// Of the node of that name.
Result<NodeCertificate> node_certificate_in(const std::filesystem::path& folder, const std::string& name);

// Whether other nodes would believe this one: to be asked before the files are used. The authority's file may hold
// several (the old one and the new one, while a cluster goes over), the certificate's be followed by those between.
// Errors name the file: io when it cannot be read; usage when it is no certificate or key, the key does not belong to
// the certificate, or others can read it (of one that is root's the group may), the authority has not signed it, or it
// is not valid now.
Status check_node(const std::filesystem::path& authority, const std::filesystem::path& certificate,
                  const std::filesystem::path& key);
inline Status check_node(const NodeCertificate& node) { return check_node(node.authority, node.certificate, node.key); }

// Until when the first certificate in the file is valid. Errors: io; usage when it holds none.
Result<std::chrono::system_clock::time_point> valid_until(const std::filesystem::path& certificate);
// "ends on 2028-11-21 13:18 UTC, in 12 days: ..."; empty while it is valid for 30 days or more.
std::string expiry_warning(std::chrono::system_clock::time_point end, std::chrono::system_clock::time_point now);
// "2028-11-21 13:18 UTC"
std::string date_text(std::chrono::system_clock::time_point time);

}  // namespace tessera
