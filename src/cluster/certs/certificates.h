// The certificates by which the nodes of a cluster recognise each other. Each cluster has an authority of its own.
// Nodes compare no names, so every process with a certificate of this authority belongs to the cluster.
//
// Keys are EC P-256 without a passphrase, in files that their owner alone can read. All files are PEM.
// src/base/files/names.h has their names.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

struct CertificateOptions {
  // Used for an authority only: the name in its certificate, for display. The rules for node names hold for it, too.
  std::string cluster = "tessera";
  // How long the certificate is valid, 1 to 36500 days. Default: 10 years for an authority, 2 years for a node.
  std::optional<int> days;
  // The time of making. The certificate is valid from an hour earlier, because clocks differ.
  std::chrono::system_clock::time_point now = std::chrono::system_clock::now();
};

// Returns an error usage unless `name` can be the name of a node: 1 to 64 of A-Z, a-z, 0-9, '.', '_' and '-', the first
// a letter or digit; and not "ca".
Status check_node_name(const std::string& name);

// Makes a new authority in `folder`. A missing folder is made, for its owner alone. Errors: usage, also when the folder
// holds an authority or others can write to it; io.
Status make_authority(const std::filesystem::path& folder, const CertificateOptions& options = {});

// Makes a node's certificate, signed by the authority in `folder`, and valid no longer than the authority. Errors:
// usage, also when the node has a certificate, the authority has expired, or others can read its key; io.
Status make_node(const std::filesystem::path& folder, const std::string& name, const CertificateOptions& options = {});

// The files of one node.
struct NodeCertificate {
  std::filesystem::path authority, certificate, key;
};

// Returns the files of the only node in `folder`, which holds what was copied to that node: ca.pem, NAME.pem and
// NAME.key. The contents are not checked; check_node() does that. Errors: usage when there is no node, or several; io.
Result<NodeCertificate> node_certificate_in(const std::filesystem::path& folder);
// Returns the files of the node of that name. Errors: usage; io.
Result<NodeCertificate> node_certificate_in(const std::filesystem::path& folder, const std::string& name);

// Checks whether other nodes would accept this one. Call it before the files are used. The authority's file may hold
// several certificates (the old and the new one, while a cluster changes over). In the certificate's file, the
// certificates between the node's and the authority's may follow. Errors name the file: io when it cannot be read;
// usage when it holds no certificate or key, the key does not belong to the certificate, others can read the key (the
// group may when root owns it), the authority has not signed the certificate, or it is not valid now.
Status check_node(const std::filesystem::path& authority, const std::filesystem::path& certificate,
                  const std::filesystem::path& key);
inline Status check_node(const NodeCertificate& node) { return check_node(node.authority, node.certificate, node.key); }

// Returns until when the first certificate in the file is valid. Errors: io; usage when it holds none.
Result<std::chrono::system_clock::time_point> valid_until(const std::filesystem::path& certificate);
// Returns "ends on 2028-11-21 13:18 UTC, in 12 days: ..."; empty when 30 days or more are left.
std::string expiry_warning(std::chrono::system_clock::time_point end, std::chrono::system_clock::time_point now);
// Returns a text like "2028-11-21 13:18 UTC".
std::string date_text(std::chrono::system_clock::time_point time);

}  // namespace tessera
