#include "src/input/remote/curl_library.h"

#include <dlfcn.h>

#include <string>

namespace tessera::remote {
namespace {

constexpr unsigned version_min = 0x074c00;  // 7.76, of RHEL 9: the first with signatures and multi_poll() in one system

// libcurl with OpenSSL, else with GnuTLS. libcurl is never unloaded, because TLS libraries keep threads and memory.
Result<void*> open_curl() {
  std::string missing;
  for (const char* name : {"libcurl.so.4", "libcurl-gnutls.so.4"}) {
    if (void* handle = ::dlopen(name, RTLD_NOW | RTLD_LOCAL)) return handle;
    if (missing.empty()) missing = ::dlerror();
  }
  return error(Errc::io, "objects on other machines need libcurl (Debian's package libcurl4): " + missing);
}

Result<CurlLibrary> load_curl() {
  BOOST_OUTCOME_TRY(handle, open_curl());
  CurlLibrary curl;
  const char* missing = nullptr;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) missing = name;
  };
#define TESSERA_CURL_FIND(name) find(curl.name, "curl_" #name);
  TESSERA_CURL_FUNCTIONS(TESSERA_CURL_FIND)
#undef TESSERA_CURL_FIND
  if (missing != nullptr) return error(Errc::io, std::string("libcurl is too old: it has no function ") + missing);
  const auto* version = curl.version_info(CURLVERSION_NOW);
  if (version->version_num < version_min)
    return error(Errc::io,
                 std::string("libcurl is too old: it is ") + version->version + ", and must be 7.76 or later");
  if (curl.global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) return error(Errc::io, "libcurl cannot be used here");
  return curl;
}

}  // namespace

Result<const CurlLibrary*> curl_library() {
  static const Result<CurlLibrary> curl = load_curl();
  if (!curl) return curl.error();
  return &curl.value();
}

}  // namespace tessera::remote
