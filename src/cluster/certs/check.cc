#include <openssl/err.h>
#include <openssl/x509_vfy.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <new>
#include <system_error>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/cluster/certs/certificates.h"
#include "src/cluster/certs/pem.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;

// What TLS requires on Debian: a strength of 112 bits, that is RSA keys from 2048 and EC keys from 224 bits, and no
// SHA-1.
constexpr int security_level = 2;

struct StackFree {
  void operator()(STACK_OF(X509) * stack) const { sk_X509_free(stack); }
};
using Store = std::unique_ptr<X509_STORE, OpensslFree<X509_STORE_free>>;
using Between = std::unique_ptr<STACK_OF(X509), StackFree>;  // does not own the certificates in it
using Verification = std::unique_ptr<X509_STORE_CTX, OpensslFree<X509_STORE_CTX_free>>;

Result<Store> trusted(const std::vector<Certificate>& authorities) {
  Store store(X509_STORE_new());
  if (!store) return openssl_error("cannot make a store of certificates");
  for (const auto& one : authorities)
    if (X509_STORE_add_cert(store.get(), one.get()) != 1) return openssl_error("cannot trust a certificate");
  return store;
}

Status check_purposes(X509& certificate, const fs::path& file) {
  for (const int purpose : {X509_PURPOSE_SSL_SERVER, X509_PURPOSE_SSL_CLIENT})
    if (X509_check_purpose(&certificate, purpose, 0) != 1)
      return error(Errc::usage,
                   file.string() + ": is not a certificate of a node: it must be for both servers and clients");
  return success();
}

Status refusal(X509_STORE_CTX& verification, const fs::path& authority, const fs::path& certificate) {
  const int reason = X509_STORE_CTX_get_error(&verification);
  switch (reason) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
    case X509_V_ERR_CERT_NOT_YET_VALID: {
      const X509& wrong = *X509_STORE_CTX_get_current_cert(&verification);
      const bool own = X509_STORE_CTX_get_error_depth(&verification) == 0;
      BOOST_OUTCOME_TRYV(check_valid_at(system_clock::now(), wrong, own ? certificate : authority));
      break;  // it has become valid meanwhile; the text below says what OpenSSL found
    }
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
      return error(Errc::usage, certificate.string() + ": is not signed by " + authority.string());
    case X509_V_ERR_OUT_OF_MEM:
      throw std::bad_alloc();
    default:
      break;
  }
  return error(Errc::usage, certificate.string() + ": cannot be used with " + authority.string() + ": " +
                                X509_verify_cert_error_string(reason));
}

}  // namespace

Status check_node(const fs::path& authority, const fs::path& certificate, const fs::path& key) {
  BOOST_OUTCOME_TRY(authorities, read_certificates(authority));
  for (const auto& one : authorities)
    if (X509_check_ca(one.get()) == 0)
      return error(Errc::usage, authority.string() + ": is not a certificate of an authority");
  BOOST_OUTCOME_TRY(chain, read_certificates(certificate));
  BOOST_OUTCOME_TRY(own_key, read_key(key));
  X509& own = *chain.front();
  if (X509_check_private_key(&own, own_key.get()) != 1) {
    ERR_clear_error();
    return error(Errc::usage, key.string() + ": does not belong to " + certificate.string());
  }
  BOOST_OUTCOME_TRYV(check_purposes(own, certificate));

  BOOST_OUTCOME_TRY(store, trusted(authorities));
  const Between between(sk_X509_new_null());
  const Verification verification(X509_STORE_CTX_new());
  if (!between || !verification) return openssl_error("cannot verify a certificate");
  for (std::size_t i = 1; i < chain.size(); ++i)
    if (sk_X509_push(between.get(), chain[i].get()) == 0) return openssl_error("cannot verify a certificate");
  if (X509_STORE_CTX_init(verification.get(), store.get(), &own, between.get()) != 1)
    return openssl_error("cannot verify a certificate");
  X509_VERIFY_PARAM_set_auth_level(X509_STORE_CTX_get0_param(verification.get()), security_level);
  const int verified = X509_verify_cert(verification.get());
  ERR_clear_error();
  return verified == 1 ? success() : refusal(*verification, authority, certificate);
}

std::string expiry_warning(system_clock::time_point end, system_clock::time_point now) {
  constexpr std::chrono::hours day{24};
  constexpr int days_ahead = 30;
  if (now >= end)
    return "has expired on " + date_text(end) + ": a node that loses its connections cannot connect again";
  const auto days = (end - now) / day;
  if (days >= days_ahead) return {};
  return "ends on " + date_text(end) + ", in " + std::to_string(days) + (days == 1 ? " day" : " days") +
         ": have the authority of the cluster make another one, and restart the node with it";
}

Result<NodeCertificate> node_certificate_in(const fs::path& folder) {
  std::vector<std::string> nodes;
  FolderReader reader(folder);
  while (const char* name = reader.next())
    if (auto node = node_of_certificate(name); !node.empty()) nodes.push_back(std::move(node));
  if (reader.error()) return io_error(folder, "cannot be read", reader.error().value());
  if (nodes.empty())
    return error(Errc::usage, folder.string() + ": holds no certificate of a node: the files " +
                                  node_certificate_file("", "NAME").string() + " and " +
                                  node_key_file("", "NAME").string() + " are missing");
  // A certificate that was copied with a chain, or an old one, has no key beside it.
  std::vector<std::string> whole;
  for (const auto& node : nodes) {
    BOOST_OUTCOME_TRY(with_key, is_there(node_key_file(folder, node)));
    if (with_key) whole.push_back(node);
  }
  if (whole.size() > 1) {
    std::sort(whole.begin(), whole.end());
    std::string names;
    for (const auto& node : whole) names += (names.empty() ? "" : ", ") + node;
    return error(Errc::usage, folder.string() + ": holds the certificates of several nodes: " + names);
  }
  return node_certificate_in(folder, whole.empty() ? nodes.front() : whole.front());
}

Result<NodeCertificate> node_certificate_in(const fs::path& folder, const std::string& name) {
  BOOST_OUTCOME_TRYV(check_node_name(name));
  NodeCertificate node{authority_file(folder), node_certificate_file(folder, name), node_key_file(folder, name)};
  for (const auto& file : {node.authority, node.certificate, node.key}) {
    BOOST_OUTCOME_TRY(there, is_there(file));
    if (!there) return error(Errc::usage, file.string() + ": is missing");
  }
  return node;
}

}  // namespace tessera
