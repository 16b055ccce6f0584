#include <arpa/inet.h>
#include <openssl/err.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <initializer_list>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/cluster/certs/certificates.h"
#include "src/cluster/certs/pem.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;

constexpr int authority_days = 3650, node_days = 730, days_max = 36500;
constexpr int serial_bits = 128;  // random: no counter is kept, and no one can guess what will be signed next
constexpr std::chrono::hours clocks_differ{1};
constexpr const char* group = "P-256";

struct Extension {
  const char* name;
  std::string value;
};

bool can_be_name(std::string_view text) {
  constexpr std::size_t length_max = 64;  // length of a common name (RFC 5280)
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";
  return !text.empty() && text.size() <= length_max && letters.find(text.front()) != std::string_view::npos &&
         std::all_of(text.begin(), text.end(), [&](char c) {
           return letters.find(c) != std::string_view::npos ||
                  std::string_view("._-").find(c) != std::string_view::npos;
         });
}

constexpr const char* rule =
    "must be 1 to 64 characters of A-Z, a-z, 0-9, '.', '_' and '-', and begin with a letter or digit";

Result<int> days_of(const CertificateOptions& options, int normal) {
  const int days = options.days.value_or(normal);
  if (days < 1 || days > days_max)
    return error(Errc::usage, "a certificate is valid for 1 to " + std::to_string(days_max) + " days");
  return days;
}

// Makes a certificate that has no subject, issuer and signature yet.
Result<Certificate> blank_certificate(EVP_PKEY& key, system_clock::time_point from, system_clock::time_point until) {
  using Number = std::unique_ptr<BIGNUM, OpensslFree<BN_free>>;
  Certificate made(X509_new());
  const Number serial(BN_new());
  const auto set = [](ASN1_TIME* time, system_clock::time_point value) {
    return time != nullptr && ASN1_TIME_set(time, system_clock::to_time_t(value)) != nullptr;
  };
  if (!made || !serial || X509_set_version(made.get(), X509_VERSION_3) != 1 ||
      BN_rand(serial.get(), serial_bits, BN_RAND_TOP_ANY, BN_RAND_BOTTOM_ANY) != 1 ||
      BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(made.get())) == nullptr ||
      !set(X509_getm_notBefore(made.get()), from) || !set(X509_getm_notAfter(made.get()), until) ||
      X509_set_pubkey(made.get(), &key) != 1)
    return openssl_error("cannot make a certificate");
  return made;
}

bool add_name(X509& certificate, const char* field, const std::string& value) {
  return X509_NAME_add_entry_by_txt(X509_get_subject_name(&certificate), field, MBSTRING_ASC,
                                    reinterpret_cast<const unsigned char*>(value.data()),
                                    static_cast<int>(value.size()), -1, 0) == 1;
}

// Sets the issuer, adds the extensions and signs `made`. `issuer` may be `made` itself.
Status sign(X509& made, X509& issuer, EVP_PKEY& issuer_key, std::initializer_list<Extension> extensions) {
  if (X509_set_issuer_name(&made, X509_get_subject_name(&issuer)) != 1) return openssl_error("cannot name the issuer");
  X509V3_CTX context;
  X509V3_set_ctx(&context, &issuer, &made, nullptr, nullptr, 0);
  X509V3_set_ctx_nodb(&context);
  for (const auto& [name, value] : extensions) {
    using Made = std::unique_ptr<X509_EXTENSION, OpensslFree<X509_EXTENSION_free>>;
    const Made extension(X509V3_EXT_nconf(nullptr, &context, name, value.c_str()));
    if (!extension || X509_add_ext(&made, extension.get(), -1) != 1)
      return openssl_error(std::string("cannot make ") + name);
  }
  if (X509_sign(&made, &issuer_key, EVP_sha256()) == 0) return openssl_error("cannot sign a certificate");
  return success();
}

Result<PrivateKey> make_key() {
  PrivateKey key(EVP_EC_gen(group));
  if (!key) return openssl_error("cannot make a key");
  return key;
}

// Makes the folder, readable for its owner alone. Error usage when it is there and others can write to it.
Status make_folder(const fs::path& folder) {
  const fs::path above = (folder.has_filename() ? folder : folder.parent_path()).parent_path();
  if (!above.empty()) {
    BOOST_OUTCOME_TRYV(make_directories(above));
  }
  if (::mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST)
    return io_error(folder, "cannot make the folder", errno);
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return io_error(folder, "cannot open", errno);
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    return error(Errc::usage, folder.string() + ": others can write in it; its rights should be 0700");
  return success();
}

// The key comes first, because a certificate alone is of no use. check_new() refuses when either file is there.
Status write_both(const fs::path& certificate_file, const X509& certificate, const fs::path& key_file,
                  const EVP_PKEY& key) {
  BOOST_OUTCOME_TRYV(write_key(key_file, key));
  const Status written = write_certificate(certificate_file, certificate);
  if (!written) {
    BOOST_OUTCOME_TRYV(remove_file(key_file));
  }
  return written;
}

Status check_new(std::initializer_list<fs::path> files, const char* what) {
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(there, is_there(file, FollowLinks::no));
    if (there) return error(Errc::usage, file.string() + ": exists already; " + what);
  }
  return success();
}

struct Authority {
  Certificate certificate;
  PrivateKey key;
};

// Returns the authority: of the certificates in the file, the one to which the key belongs.
Result<Authority> read_authority(const fs::path& folder, system_clock::time_point now) {
  const fs::path file = authority_file(folder), key_file = authority_key_file(folder);
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there)
    return error(Errc::usage,
                 folder.string() + ": holds no authority of a cluster: there is no " + file.filename().string());
  BOOST_OUTCOME_TRY(all, read_certificates(file));
  BOOST_OUTCOME_TRY(key, read_key(key_file));
  for (auto& certificate : all) {
    const bool belongs = X509_check_private_key(certificate.get(), key.get()) == 1;
    ERR_clear_error();
    if (!belongs) continue;
    BOOST_OUTCOME_TRYV(check_valid_at(now, *certificate, file));
    return Authority{std::move(certificate), std::move(key)};
  }
  return error(Errc::usage, key_file.string() + ": does not belong to " + file.string());
}

std::string alternative_name(const std::string& name) {
  in_addr address{};
  return (::inet_pton(AF_INET, name.c_str(), &address) == 1 ? "IP:" : "DNS:") + name;
}

}  // namespace

Status check_node_name(const std::string& name) {
  if (!can_be_name(name)) return error(Errc::usage, "'" + name + "' cannot be the name of a node: it " + rule);
  if (node_certificate_file("", name) == authority_file(""))
    return error(Errc::usage, "'" + name + "' cannot be the name of a node: the files of the authority have this name");
  return success();
}

Status make_authority(const fs::path& folder, const CertificateOptions& options) {
  if (!can_be_name(options.cluster))
    return error(Errc::usage, "'" + options.cluster + "' cannot be the name of a cluster: it " + rule);
  BOOST_OUTCOME_TRY(days, days_of(options, authority_days));
  BOOST_OUTCOME_TRYV(make_folder(folder));
  const auto lock = FolderLock::take(folder);
  if (!lock) return lock.error();
  const fs::path file = authority_file(folder), key_file = authority_key_file(folder);
  BOOST_OUTCOME_TRYV(check_new({file, key_file}, "another authority would not know the nodes of this one"));
  BOOST_OUTCOME_TRY(key, make_key());
  BOOST_OUTCOME_TRY(made, blank_certificate(*key, options.now - clocks_differ, options.now + std::chrono::days(days)));
  // The authority's name has two parts and a node's has one, so no node has the same name.
  if (!add_name(*made, "O", "Tessera cluster") || !add_name(*made, "CN", options.cluster))
    return openssl_error("cannot name the authority");
  BOOST_OUTCOME_TRYV(sign(*made, *made, *key,
                          {{"basicConstraints", "critical,CA:TRUE,pathlen:0"},
                           {"keyUsage", "critical,keyCertSign,cRLSign"},
                           {"subjectKeyIdentifier", "hash"}}));
  return write_both(file, *made, key_file, *key);
}

Status make_node(const fs::path& folder, const std::string& name, const CertificateOptions& options) {
  BOOST_OUTCOME_TRYV(check_node_name(name));
  BOOST_OUTCOME_TRY(days, days_of(options, node_days));
  const auto lock = FolderLock::take(folder);
  if (!lock) return lock.error();
  BOOST_OUTCOME_TRY(authority, read_authority(folder, options.now));
  const fs::path file = node_certificate_file(folder, name), key_file = node_key_file(folder, name);
  BOOST_OUTCOME_TRYV(check_new({file, key_file}, "another node needs another name"));
  BOOST_OUTCOME_TRY(key, make_key());
  const auto until = std::min<system_clock::time_point>(options.now + std::chrono::days(days),
                                                        time_of(X509_get0_notAfter(authority.certificate.get())));
  BOOST_OUTCOME_TRY(made, blank_certificate(*key, options.now - clocks_differ, until));
  if (!add_name(*made, "CN", name)) return openssl_error("cannot name the node");
  BOOST_OUTCOME_TRYV(sign(*made, *authority.certificate, *authority.key,
                          {{"basicConstraints", "critical,CA:FALSE"},
                           {"keyUsage", "critical,digitalSignature"},
                           {"extendedKeyUsage", "serverAuth,clientAuth"},
                           {"subjectAltName", alternative_name(name)},
                           {"subjectKeyIdentifier", "hash"},
                           {"authorityKeyIdentifier", "keyid:always"}}));
  return write_both(file, *made, key_file, *key);
}

}  // namespace tessera
