#include "actors/cluster/handshakes.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <openssl/err.h>
#include <openssl/x509_vfy.h>
#include <sys/socket.h>

#include <array>
#include <ctime>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::minutes again_after{10};
constexpr std::size_t kept_max = 256;  // sentences: any process that connects can cause new ones

class Troubles {
 public:
  void add(std::string sentence) {
    const std::lock_guard lock(mutex_);
    if (new_.size() < kept_max) new_.push_back(std::move(sentence));
  }
  std::vector<std::string> take(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    std::erase_if(told_, [&](const auto& entry) { return now - entry.second >= again_after; });
    std::vector<std::string> untold;
    for (std::string& sentence : std::exchange(new_, {})) {
      if (told_.size() < kept_max && told_.try_emplace(sentence, now).second) untold.push_back(std::move(sentence));
    }
    return untold;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> new_;
  std::map<std::string, Clock::time_point> told_;
};

Troubles& troubles() {
  static Troubles all;
  return all;
}

// Returns the address of the other side. The port is left out when that side has connected, because it is another port
// each time.
std::string peer_of(const SSL* ssl) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  auto* const plain = reinterpret_cast<sockaddr*>(&address);
  if (::getpeername(SSL_get_fd(ssl), plain, &length) != 0 ||
      ::getnameinfo(plain, length, host.data(), host.size(), port.data(), port.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return "somebody";
  return SSL_is_server(ssl) == 1 ? std::string(host.data()) : std::string(host.data()) + ":" + port.data();
}

std::string date_of(const ASN1_TIME* time) {
  std::tm date{};
  if (ASN1_TIME_to_tm(time, &date) != 1) return "a date that cannot be read";
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%F %H:%M UTC", &date);
  return text.data();
}

// Returns the common name in quotes. Characters that a log would not show become '?'.
std::string name_of(const X509_NAME* whole) {
  std::array<char, 65> name{};
  if (!whole || X509_NAME_get_text_by_NID(whole, NID_commonName, name.data(), name.size()) < 0) return "without a name";
  for (char& c : name) {
    if (c != 0 && (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f)) c = '?';
  }
  return std::string("'") + name.data() + "'";
}

// `own` is the certificate of the other side, `certificate` the one in its chain that is wrong.
std::string wrong_with(int reason, const X509* own, const X509* certificate) {
  const std::string name = "its certificate " + name_of(X509_get_subject_name(certificate)) + " ";
  switch (reason) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return name + "has expired on " + date_of(X509_get0_notAfter(certificate));
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return name + "is valid from " + date_of(X509_get0_notBefore(certificate)) + " on: a clock may be wrong";
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
      return "its certificate " + name_of(X509_get_subject_name(own)) + " is of another authority, " +
             name_of(X509_get_issuer_name(own));
    default:
      return name + "is not valid: " + X509_verify_cert_error_string(reason);
  }
}

std::string refused(const SSL* ssl) {
  return SSL_is_server(ssl) == 1 ? "a connection from " + peer_of(ssl) + " is refused: "
                                 : "the connection to " + peer_of(ssl) + " is refused: ";
}

int look(int fits, X509_STORE_CTX* verification) {
  if (fits == 1) return fits;
  const auto* const ssl =
      static_cast<const SSL*>(X509_STORE_CTX_get_ex_data(verification, SSL_get_ex_data_X509_STORE_CTX_idx()));
  const X509* const certificate = X509_STORE_CTX_get_current_cert(verification);
  const X509* const own = X509_STORE_CTX_get0_cert(verification);
  if (ssl && own && certificate)
    troubles().add(refused(ssl) + wrong_with(X509_STORE_CTX_get_error(verification), own, certificate));
  return fits;
}

// Returns the meaning of an alert from the other side; null when the alert is not about a certificate.
const char* refused_by_other(int reason) {
  switch (reason) {
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
      return "it has expired, or a clock is wrong";
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
      return "it is of another authority";
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
    case SSL_R_SSLV3_ALERT_UNSUPPORTED_CERTIFICATE:
      return "it is not valid";
    default:
      return nullptr;
  }
}

}  // namespace

bool watch_handshake(SSL* ssl) {
  if (SSL_get_fd(ssl) < 0) return true;  // a connection of an HTTP server in this process
  if (SSL_get_verify_callback(ssl) != look) SSL_set_verify(ssl, SSL_get_verify_mode(ssl), look);
  // CAF makes its contexts without a version, so the system's configuration would decide.
  if (SSL_set_min_proto_version(ssl, TLS1_3_VERSION) == 1) return true;
  troubles().add(refused(ssl) + "nodes speak TLS 1.3, which the configuration of OpenSSL on this machine forbids");
  return false;
}

void note_failure(SSL* ssl) {
  const unsigned long failed = ERR_peek_last_error();
  if (failed == 0 || ERR_GET_LIB(failed) != ERR_LIB_SSL || SSL_get_fd(ssl) < 0) return;
  const int reason = ERR_GET_REASON(failed);
  if (const char* why = refused_by_other(reason)) {
    troubles().add(peer_of(ssl) + " refuses the certificate of this node: " + why);
  } else if (reason == SSL_R_PEER_DID_NOT_RETURN_A_CERTIFICATE) {
    troubles().add(refused(ssl) + "it has shown no certificate");
  } else if (reason == SSL_R_UNSUPPORTED_PROTOCOL || reason == SSL_R_TLSV1_ALERT_PROTOCOL_VERSION) {
    troubles().add(refused(ssl) + "it does not speak TLS 1.3");
  }
}

std::vector<std::string> take_handshake_troubles(std::chrono::steady_clock::time_point now) {
  return troubles().take(now);
}

}  // namespace tessera
